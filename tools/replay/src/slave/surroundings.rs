//! The node around the redundancy of a slave: carries out its decisions, and keeps what outlives a reset.

use ecss_can::heartbeat::NodeControl;
use ecss_can::redundancy::{Parameters, Retained, SlaveAction, SlaveNode};
use ecss_can::types::{Bus, Instant, PerBus};

use crate::machine::Produced;

/// Line that the application logs before it resets the chip.
pub const RESET: &str = "reset by the master";

/// State of the node beside its redundancy.
pub struct Memory {
    /// Node-ID, NMT state and heartbeat.
    pub control: NodeControl,
    /// Parameters of the profile.
    parameters: Parameters,
    /// Bdefault in the object dictionary.
    bdefault: Bus,
    /// Bdefault in the parameter store.
    pub stored: Bus,
    /// RAM that outlives a reset of the chip.
    pub retained: Retained,
    /// Frames received since the start.
    pub received: PerBus<u32>,
    /// Errors that were reported and are not gone: error code, source.
    errors: Vec<(u16, u8)>,
    /// The redundancy has asked for the reset of the chip, which has not come yet.
    waits_for_reset: bool,
}

impl Memory {
    /// Makes the memory of a new board.
    pub fn new(control: NodeControl, parameters: Parameters) -> Memory {
        Memory {
            control,
            parameters,
            bdefault: parameters.bdefault,
            stored: parameters.bdefault,
            retained: Retained::default(),
            received: PerBus::default(),
            errors: Vec::new(),
            waits_for_reset: false,
        }
    }

    /// Forgets what a reset of the chip clears. The slave starts on `bdefault`.
    pub fn restart(&mut self, control: NodeControl, bdefault: Bus) {
        (self.control, self.bdefault) = (control, bdefault);
        (self.received, self.errors, self.waits_for_reset) = Default::default();
    }
}

/// The node in one step.
pub struct Surroundings<'a> {
    pub memory: &'a mut Memory,
    pub produced: &'a mut Vec<Produced>,
    pub now: Instant,
}

impl Surroundings<'_> {
    /// The application logs a line.
    pub fn log(&mut self, line: String) {
        self.produced.push(Produced::line(self.now, line));
    }
}

impl SlaveNode for Surroundings<'_> {
    fn control(&mut self) -> &mut NodeControl {
        &mut self.memory.control
    }

    fn received(&self) -> PerBus<u32> {
        self.memory.received
    }

    fn restore_communication(&mut self) -> Parameters {
        let parameters = Parameters { bdefault: self.memory.bdefault, ctoggle: 0, ..self.memory.parameters };
        self.memory.control.set_period(parameters.producer, self.now);
        parameters
    }

    fn show(&mut self, parameters: &Parameters) {
        self.memory.bdefault = parameters.bdefault;
    }

    fn note_bdefault(&mut self, bus: Bus) -> Option<bool> {
        self.memory.stored = bus;
        Some(true)
    }

    fn act(&mut self, action: SlaveAction) {
        match action {
            SlaveAction::BootUp { bus } => {
                let boot_up = self.memory.control.boot(self.now);
                self.produced.push(Produced::frame(self.now, bus, boot_up));
                self.log(format!("{:?}", self.memory.control.state()));
            }
            SlaveAction::Entered(state) => self.log(format!("{state:?}")),
            SlaveAction::ActiveBus { bus, cause, .. } => self.log(format!("active bus: {bus:?} ({cause:?})")),
            SlaveAction::MasterMissed { bus } => self.log(format!("master missed on {bus:?}")),
            SlaveAction::GaveUp { bus } => self.log(format!("search given up, listening on {bus:?}")),
            SlaveAction::Raise { code, source } => {
                let error = (code.get(), source);
                if !self.memory.errors.contains(&error) {
                    self.memory.errors.push(error);
                    self.produced.push(Produced::emergency(self.now, error));
                }
            }
            SlaveAction::Clear { code, source } => {
                self.memory.errors.retain(|error| *error != (code.get(), source));
            }
            SlaveAction::Clash { bus, yields } => {
                self.log(format!("another node with this Node-ID on {bus:?}, yields: {yields}"));
            }
            SlaveAction::ClashOver => self.log("the other node with this Node-ID is silent".into()),
            SlaveAction::ResetIgnored { bus, command } => {
                self.log(format!("{command:?} on {bus:?} ignored: the master is not heard"));
            }
            SlaveAction::Retain(retained) => self.memory.retained = retained,
            SlaveAction::BdefaultNoted { bus, is_kept: true } => self.log(format!("Bdefault {bus:?} kept")),
            SlaveAction::BdefaultNoted { bus, is_kept: false } => {
                self.log(format!("Bdefault {bus:?} not kept"));
            }
            // Repeated with each frame until the chip is reset. The application resets it after the first one.
            SlaveAction::ResetNode if self.memory.waits_for_reset => {}
            SlaveAction::ResetNode => {
                self.memory.waits_for_reset = true;
                self.log(RESET.into());
            }
            SlaveAction::SendEmergencies { .. } => {}
        }
    }
}
