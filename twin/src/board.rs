//! One emulated board: a core, its peripherals, a crystal, straps, and a debug probe that reads the log.

mod access;
mod debug;
mod defect;
mod devices;
mod edge;
mod fittings;
mod flash;
mod follow;
mod network;
mod run;
mod same;
mod sleep;
mod spin;
mod supply;
mod upset;

use std::fmt;
use std::sync::Arc;

pub use access::AccessError;
pub use debug::HaltError;
pub use defect::Defect;
pub use edge::Edge;
pub use fittings::Fittings;
pub(crate) use fittings::Plug;
use flash::FlashCare;
pub use flash::Remains;
use network::Participation;
use spin::Spin;

pub use crate::accelerator::FlashTiming;
use crate::bxcan::{BadAccess, IrqLines, Side, Stats};
use crate::chip::{Chip, WatchedRam};
pub use crate::chip::{Use, Uses};
use crate::cpu::{Config, Core};
pub use crate::cpu::{CoreRegister, Registers, StateRegister};
use crate::crystal::Crystal;
use crate::devices::Lm75;
use crate::image::{Image, Symbol};
pub use crate::memory::NotMemory;
use crate::model::Model;
use crate::peripherals::{Clocks, IrqLevels, Peripherals, PinChange};
use crate::pin::Pin;
use crate::rtt::{LogLine, Rtt};
use crate::wire::time::Time;
use crate::wire::timing::BitTiming;

/// Configuration of a board: model, program, hardware and position.
#[derive(Clone, Debug)]
pub struct BoardConfig {
    /// Name in logs and errors.
    pub name: String,
    /// Model of the board.
    pub model: Model,
    /// The program in flash.
    pub image: Arc<Image>,
    /// Pins that the harness ties to a level; the others float.
    pub straps: Vec<(Pin, bool)>,
    /// Crystal that drives the clocks of the chip.
    pub crystal: Crystal,
    /// Position on both wires, in metres.
    pub position_m: f64,
    /// Instant of power-on.
    pub power_on_at: Time,
    /// Wires and surroundings.
    pub fittings: Fittings,
}

/// State of a board's core.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum State {
    /// Without power.
    Off,
    /// Executing, or asleep until an interrupt.
    Running,
    /// In a HardFault handler that loops for ever. Peripherals continue.
    Stuck,
    /// Halted by a debugger ([`EmulatedBoard::halt`]). Peripherals continue.
    Halted,
    /// Locked up: a fault that no handler can take. Peripherals continue.
    LockedUp,
    /// Stopped at an access that the model refused.
    Refused(AccessError),
}

/// Counters of a board since the start of the simulation.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Counters {
    /// Instructions executed, exception entries included.
    pub instructions: u64,
    /// Core cycles awake, by the core's timing model and the flash's ([`FlashTiming`]).
    pub cycles_awake: u64,
    /// Panic messages, and HardFaults without a panic message before.
    pub panics: u64,
    /// Lock-ups of the core.
    pub lockups: u64,
    /// Resets requested by the program (AIRCR.SYSRESETREQ).
    pub system_resets: u64,
    /// Resets by the independent watchdog.
    pub watchdog_resets: u64,
    /// Bytes, half-words and words whose programming into flash the program began.
    pub flash_programs: u64,
    /// Sectors of flash whose erase the program began.
    pub flash_erases: u64,
    /// Log frames that did not decode.
    pub malformed_logs: u64,
}

/// One board. A copy continues exactly as the original and shares no state with it; copies share flash until one of them changes it.
#[derive(Clone)]
pub struct EmulatedBoard {
    config: BoardConfig,
    core: Core,
    chip: Chip,
    clocks: Option<Clocks>,
    state: State,
    asleep: bool,
    lines: IrqLevels,
    /// Interrupt lines of the CAN controllers from which `lines` was derived.
    can_lines: [IrqLines; 2],
    nmi: bool,
    /// The cycle of the next event of a timer, the RTC, the watchdog or the flash; `u64::MAX` without one.
    timer_event: u64,
    spin: Spin,
    /// Deadline of the watchdog, and the cycle at which it is detected.
    watchdog: Option<(Time, u64)>,
    flash: FlashCare,
    captures_exchanged: bool,
    rtt: Rtt,
    log: Vec<LogLine>,
    edges: Vec<Edge>,
    panicked: bool,
    counters: Counters,
    /// Frames admitted before the last reset.
    admitted_before: u64,
    /// Reason, as last logged, why CAN1 and CAN2 reach no bus.
    unconnected: [Option<String>; 2],
    /// Participation of CAN1 and CAN2 in their buses.
    participation: [Participation; 2],
    warnings: Vec<String>,
    /// First uses of RAM, while they are recorded.
    uses: Option<Box<Uses>>,
}

impl fmt::Debug for EmulatedBoard {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("EmulatedBoard")
            .field("name", &self.config.name)
            .field("state", &self.state)
            .field("now", &self.chip.clock.now())
            .field("counters", &self.counters)
            .finish_non_exhaustive()
    }
}

impl EmulatedBoard {
    /// A board without power. `serial` goes into its unique ID.
    ///
    /// # Panics
    /// When the crystal is more than 1000 ppm off, LSI outside its data sheet, or the image is for another part: mistakes in a test, not
    /// inputs. [`Image::check_part`] checks an image that is an input.
    pub fn new(config: BoardConfig, serial: u32) -> Self {
        let ppm = config.crystal.ppm;
        assert!(ppm.abs() <= 1000.0, "a crystal is not {ppm} ppm off");
        if let Err(misfit) = config.image.check_part(config.model.part) {
            panic!("{}: {misfit}", config.name);
        }
        let Fittings { capture_wires, lsi_hz, temperature_c, flash_timing, revision_a, hse_starts, .. } =
            config.fittings;
        assert!((17_000..=47_000).contains(&lsi_hz), "LSI runs at 17 to 47 kHz, not {lsi_hz} Hz");
        let mut peripherals = Peripherals::new(config.model, serial);
        peripherals.set_lsi(lsi_hz);
        peripherals.i2c.set_temperature(temperature_c);
        peripherals.flash.speed = config.fittings.flash_speed;
        peripherals.rcc.hse_starts = hse_starts;
        if revision_a {
            peripherals.set_revision_a();
        }
        if config.fittings.thermometer {
            peripherals.attach_i2c(0, 0, Box::new(Lm75::new(Lm75::ADDRESS, temperature_c)));
        }
        if capture_wires {
            // A bus at rest is recessive.
            for pin in config.model.pins.capture.into_iter().flatten() {
                peripherals.drive(pin, Some(true));
            }
        }
        for &(pin, level) in &config.straps {
            peripherals.drive(pin, Some(level));
        }
        let mut core = Core::new(Config::stm32f4(config.model.part.flash_bytes()));
        core.share(config.image.code());
        EmulatedBoard {
            core,
            chip: Chip::new(peripherals, config.image.flash(), flash_timing, config.crystal),
            clocks: None,
            state: State::Off,
            asleep: false,
            lines: [0; 3],
            can_lines: Default::default(),
            nmi: false,
            timer_event: u64::MAX,
            spin: Spin::default(),
            watchdog: None,
            flash: FlashCare::default(),
            captures_exchanged: false,
            rtt: Rtt::new(&config.image),
            log: Vec::new(),
            edges: Vec::new(),
            panicked: false,
            counters: Counters::default(),
            admitted_before: 0,
            unconnected: [None, None],
            participation: [Participation::None; 2],
            warnings: Vec::new(),
            uses: None,
            config,
        }
    }

    /// Returns the configuration.
    pub fn config(&self) -> &BoardConfig {
        &self.config
    }

    /// Returns the state of the core.
    pub fn state(&self) -> &State {
        &self.state
    }

    /// Returns the counters.
    pub fn counters(&self) -> Counters {
        Counters { malformed_logs: self.rtt.malformed, ..self.counters }
    }

    /// The variable or function `name` of the image.
    pub fn symbol(&self, name: &str) -> Option<Symbol> {
        self.config.image.symbol(name)
    }

    /// The function of its image that has an instruction at `address`.
    pub fn function_at(&self, address: u32) -> Option<&str> {
        self.config.image.function_at(address)
    }

    /// Reads flash or RAM without side effects.
    ///
    /// # Errors
    /// [`NotMemory`] when the range leaves both.
    pub fn read_memory(&self, address: u32, len: usize) -> Result<Vec<u8>, NotMemory> {
        let mut bytes = vec![0; len];
        self.chip.memory.copy_out(address, &mut bytes)?;
        Ok(bytes)
    }

    /// Puts content into RAM from outside, as a debug probe does.
    ///
    /// # Errors
    /// [`NotMemory`] when the range leaves RAM.
    pub fn write_memory(&mut self, address: u32, bytes: &[u8]) -> Result<(), NotMemory> {
        self.chip.memory.copy_in(address, bytes)
    }

    /// Core registers.
    pub fn registers(&self) -> Registers {
        self.core.registers()
    }

    /// HCLK now, Hz, without the crystal's error.
    pub fn hclk(&self) -> u64 {
        self.chip.peripherals.rcc.clocks().hclk
    }

    /// Ties an input to a level, or lets it float.
    pub fn drive(&mut self, pin: Pin, level: Option<bool>) {
        self.chip.peripherals.drive(pin, level);
        self.refresh();
    }

    /// Changes the receive line of a bus to these levels (high is recessive) at these instants, in chronological order.
    /// An instant may be before the board's present by the time that the board ran ahead; the timer captures the count
    /// of that instant. The program sees the consequences (interrupt, DMA) from now on.
    pub fn can_rx_edges(&mut self, side: Side, edges: impl IntoIterator<Item = (Time, bool)>) {
        if !self.config.fittings.capture_wires {
            return;
        }
        let side = if self.captures_exchanged { side.other() } else { side };
        let (powered, now) = (self.is_powered(), self.chip.clock.now());
        let mut is_noticed = false;
        for (at, level) in edges {
            let cycle = self.chip.clock.cycle_at(at);
            if self.chip.peripherals.capture_edge(side, cycle, level) && powered {
                is_noticed = true;
                // DMA moves a capture before the next one.
                let uses = self.uses.as_deref_mut();
                let mut ram = WatchedRam { memory: &mut self.chip.memory, uses };
                self.chip.peripherals.transfer(now, &mut ram);
            }
        }
        if is_noticed {
            self.refresh();
        }
    }

    /// Returns the count of TIM5, whose captures stamp frames, at `at`, by the board's own crystal and without
    /// rounding. `at` may be in the past if neither the clock tree nor the counter was set since.
    pub fn capture_clock(&self, at: Time) -> f64 {
        self.chip.peripherals.capture_clock(self.chip.clock.cycle_at(at))
    }

    /// Sets the log to blocking mode and removes the debug probe. The log is no longer read.
    pub fn pull_probe(&mut self) {
        self.drain();
        self.rtt.pull(&mut self.chip.memory);
    }

    /// Returns FLASH_ACR as last set by the program.
    pub fn flash_acr(&self) -> u32 {
        self.chip.peripherals.flash.acr
    }

    /// Level of a pin as its port sees it.
    pub fn pin_level(&self, pin: Pin) -> bool {
        self.chip.peripherals.pin_level(pin)
    }

    /// Returns the statistics of a CAN controller since power-on.
    pub fn can_stats(&self, side: Side) -> Stats {
        self.chip.peripherals.can.stats(side)
    }

    /// Reads a register of the CAN controllers at `offset` from 4000 6400h, without side effects.
    ///
    /// # Errors
    /// [`BadAccess`] where there is no register.
    pub fn can_register(&self, offset: u32) -> Result<u32, BadAccess> {
        self.chip.peripherals.can.read(offset)
    }

    /// Writes a register of the CAN controllers now, as the program would. Use it to flip bits.
    ///
    /// # Errors
    /// [`BadAccess`] where there is no register.
    pub fn set_can_register(&mut self, offset: u32, value: u32) -> Result<(), BadAccess> {
        let now = self.now();
        self.chip.peripherals.can.write(offset, value, now)?;
        self.refresh();
        Ok(())
    }

    /// Returns CAN_BTR of a controller as last set by the program.
    pub fn can_btr(&self, side: Side) -> u32 {
        self.chip.peripherals.can.btr(side)
    }

    /// Returns the bit timing of a CAN controller by the board's crystal; `None` while it takes part in no bus.
    pub fn bit_timing(&self, side: Side) -> Option<BitTiming> {
        Some(self.chip.peripherals.can_registers(side)?.attachment()?.timing)
    }

    /// Frames that passed the filters of both controllers since the last reset, lost ones included.
    pub fn admitted(&self) -> u64 {
        self.admitted_in_all() - self.admitted_before
    }

    fn admitted_in_all(&self) -> u64 {
        [Side::Can1, Side::Can2].iter().map(|side| self.can_stats(*side).admitted()).sum()
    }

    /// Edges that timers made at pins since the last call, each at its own instant by the board's crystal.
    pub fn take_edges(&mut self) -> Vec<Edge> {
        std::mem::take(&mut self.edges)
    }

    /// Changes of output pins by stores of the program since the last call.
    pub fn take_pin_changes(&mut self) -> Vec<PinChange> {
        std::mem::take(&mut self.chip.peripherals.pin_changes)
    }

    /// Returns mismatches of image and board since the start of the simulation, each once: a controller on other pins
    /// than its transceiver, an unusual bit rate. They are also in the log.
    pub fn warnings(&self) -> &[String] {
        &self.warnings
    }

    /// Log lines since the last call.
    pub fn take_log(&mut self) -> Vec<LogLine> {
        std::mem::take(&mut self.log)
    }

    pub(crate) fn peripherals_mut(&mut self) -> &mut Peripherals {
        &mut self.chip.peripherals
    }

    /// Returns whether the board has power.
    pub fn is_powered(&self) -> bool {
        self.state != State::Off
    }

    /// Returns the transceiver to which a controller is connected, named by the controller of its bus.
    pub(crate) fn transceiver(&self, controller: Side) -> Option<Side> {
        match self.config.fittings.transceiver_switch {
            None => Some(controller),
            Some(_) if controller == Side::Can2 => None,
            Some(pin) if self.chip.peripherals.pin_level(pin) => Some(Side::Can2),
            Some(_) => Some(Side::Can1),
        }
    }
}
