//! One emulated board: a core, its peripherals, a crystal, straps, a debug probe that listens.

mod access;
mod debug;
mod defect;
mod devices;
mod edge;
mod fittings;
mod flash;
mod network;
mod spin;
mod supply;

use std::fmt;
use std::sync::Arc;

use can_wire::time::Time;

pub use access::AccessError;
pub use debug::HaltError;
pub use defect::Defect;
use devices::DmaMemory;
pub use devices::SerialWord;
pub use edge::Edge;
pub use fittings::Fittings;
pub(crate) use fittings::Plug;
use flash::FlashCare;
pub use flash::Remains;
use spin::Spin;

pub use crate::accelerator::FlashTiming;
use crate::bxcan::{Side, Stats};
use crate::clock::BoardClock;
use crate::cpu::{CortexM4, NotMemory, Registers, Step};
use crate::crystal::Crystal;
use crate::devices::Lm75;
use crate::image::{Image, Symbol};
use crate::link::{Link, RefusedAccess};
use crate::mmio::Refusal;
use crate::model::Model;
use crate::peripherals::{Clocks, IrqLevels, Peripherals, Pin, PinChange, ResetCause};
use crate::rtt::{Line, Rtt};

/// Where the wires from CAN_RX of CAN1 and CAN2 end.
const CAPTURE_PINS: [Pin; 2] = [Pin::new('A', 0), Pin::new('A', 1)];

/// What a board is made of and where it sits.
#[derive(Clone, Debug)]
pub struct BoardConfig {
    /// For logs and errors.
    pub name: String,
    /// Which board it is.
    pub model: Model,
    /// The program in flash.
    pub image: Arc<Image>,
    /// Pins that the harness ties to a level; the others float.
    pub straps: Vec<(Pin, bool)>,
    /// What the clocks of the chip follow.
    pub crystal: Crystal,
    /// Where it hangs on both wires, metres.
    pub position_m: f64,
    /// When power comes up.
    pub power_on_at: Time,
    /// Wires and surroundings.
    pub fittings: Fittings,
}

/// Whether a board's core runs.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum State {
    /// Without power.
    Off,
    /// Executing, or asleep until an interrupt.
    Running,
    /// In a HardFault handler that will never leave its loop. Peripherals go on.
    Stuck,
    /// A debugger has halted it ([`EmulatedBoard::halt`]). Peripherals go on.
    Halted,
    /// Locked up: a fault that no handler can take. Peripherals go on.
    LockedUp,
    /// Stopped at an access that the model refused.
    Refused(AccessError),
}

/// What happened to a board since the start of the simulation.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Counters {
    /// Instructions executed, exception entries included.
    pub instructions: u64,
    /// Core cycles awake, by the core's timing model and the flash's ([`FlashTiming`]).
    pub cycles_awake: u64,
    /// Panic messages, and HardFaults that no panic message announced.
    pub panics: u64,
    /// Lock-ups of the core.
    pub lockups: u64,
    /// Resets that the program asked for (AIRCR.SYSRESETREQ).
    pub system_resets: u64,
    /// Resets by the independent watchdog.
    pub watchdog_resets: u64,
    /// Bytes, half-words and words that the program began to put into flash.
    pub flash_programs: u64,
    /// Sectors of flash that it began to erase.
    pub flash_erases: u64,
    /// Log frames that did not decode.
    pub malformed_logs: u64,
}

/// One board.
pub struct EmulatedBoard {
    config: BoardConfig,
    link: Arc<Link>,
    cpu: CortexM4,
    clock: BoardClock,
    clocks: Option<Clocks>,
    state: State,
    asleep: bool,
    /// The cycle at which SysTick wakes the sleeping core.
    systick: u64,
    lines: IrqLevels,
    nmi: bool,
    /// The cycle of the next event of a timer, the RTC, the watchdog or the flash; `u64::MAX` without one.
    timer_event: u64,
    spin: Spin,
    /// When the watchdog runs out, and the cycle at which that is noticed.
    watchdog: Option<(Time, u64)>,
    flash: FlashCare,
    thermometer: Option<Lm75>,
    captures_exchanged: bool,
    rtt: Rtt,
    log: Vec<Line>,
    edges: Vec<Edge>,
    serial: Vec<SerialWord>,
    panicked: bool,
    counters: Counters,
    /// Frames admitted before the last reset.
    admitted_before: u64,
    /// Why CAN1 and CAN2 reach no bus, as it was last logged.
    unconnected: [Option<String>; 2],
}

impl fmt::Debug for EmulatedBoard {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("EmulatedBoard")
            .field("name", &self.config.name)
            .field("state", &self.state)
            .field("now", &self.clock.now())
            .field("counters", &self.counters)
            .finish_non_exhaustive()
    }
}

impl EmulatedBoard {
    /// A board without power. `serial` goes into its unique ID.
    ///
    /// # Panics
    /// When the crystal is more than 1000 ppm off, LSI outside its data sheet or the flash too small for the image:
    /// mistakes in a test, not inputs.
    pub fn new(config: BoardConfig, serial: u32) -> Self {
        let ppm = config.crystal.ppm;
        assert!(ppm.abs() <= 1000.0, "a crystal is not {ppm} ppm off");
        let flash_bytes = config.model.part.flash_bytes() as usize;
        assert!(config.image.flash().len() <= flash_bytes, "{}: the image does not fit", config.name);
        let Fittings { capture_wires, lsi_hz, temperature_c, flash_timing, revision_a, hse_starts, .. } =
            config.fittings;
        let thermometer = config.fittings.thermometer.then(|| Lm75::new(Lm75::ADDRESS, temperature_c));
        assert!((17_000..=47_000).contains(&lsi_hz), "LSI runs at 17 to 47 kHz, not {lsi_hz} Hz");
        let mut peripherals = Peripherals::new(config.model, serial);
        peripherals.set_lsi(lsi_hz);
        peripherals.set_temperature(temperature_c);
        peripherals.flash().set_speed(config.fittings.flash_speed);
        peripherals.set_hse(hse_starts);
        if revision_a {
            peripherals.set_revision_a();
        }
        if let Some(thermometer) = thermometer.clone() {
            peripherals.attach_i2c(0, 0, Box::new(thermometer));
        }
        let link = Arc::new(Link::new(peripherals, flash_timing));
        if capture_wires {
            // A bus at rest is recessive.
            for pin in CAPTURE_PINS {
                link.peripherals().drive(pin, Some(true));
            }
        }
        for &(pin, level) in &config.straps {
            link.peripherals().drive(pin, Some(level));
        }
        EmulatedBoard {
            cpu: CortexM4::new(config.model.part, config.image.flash(), link.clone()),
            link,
            clock: BoardClock::new(config.crystal),
            clocks: None,
            state: State::Off,
            asleep: false,
            systick: u64::MAX,
            lines: [0; 3],
            nmi: false,
            timer_event: u64::MAX,
            spin: Spin::default(),
            watchdog: None,
            flash: FlashCare::default(),
            thermometer,
            captures_exchanged: false,
            rtt: Rtt::new(&config.image),
            log: Vec::new(),
            edges: Vec::new(),
            serial: Vec::new(),
            panicked: false,
            counters: Counters::default(),
            admitted_before: 0,
            unconnected: [None, None],
            config,
        }
    }

    /// As configured.
    pub fn config(&self) -> &BoardConfig {
        &self.config
    }

    /// Whether the core runs.
    pub fn state(&self) -> &State {
        &self.state
    }

    /// What happened so far.
    pub fn counters(&self) -> Counters {
        Counters { malformed_logs: self.rtt.malformed(), ..self.counters }
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
        self.cpu.read_memory(address, &mut bytes)?;
        Ok(bytes)
    }

    /// Puts content into RAM from outside, as a debug probe does.
    ///
    /// # Errors
    /// [`NotMemory`] when the range leaves RAM.
    pub fn write_memory(&mut self, address: u32, bytes: &[u8]) -> Result<(), NotMemory> {
        self.cpu.write_memory(address, bytes)
    }

    /// Core registers.
    pub fn registers(&self) -> Registers {
        self.cpu.registers()
    }

    /// HCLK now, Hz, without the crystal's error.
    pub fn hclk(&self) -> u64 {
        self.link.peripherals().clocks().hclk
    }

    /// Ties an input to a level, or lets it float.
    pub fn drive(&mut self, pin: Pin, level: Option<bool>) {
        self.link.peripherals().drive(pin, level);
        self.refresh();
    }

    /// The receive line of a bus changes to `level` (high is recessive) at `at`. In the order of time for each bus; `at`
    /// may lie before the board's present by as much as the board ran ahead, and the timer captures the count of that
    /// instant. What follows from it (interrupt, DMA) the program meets from now on.
    pub fn can_rx_edge(&mut self, side: Side, at: Time, level: bool) {
        if !self.config.fittings.capture_wires {
            return;
        }
        let side = if self.captures_exchanged { side.other() } else { side };
        let cycle = self.clock.cycle_at(at);
        let told = self.link.peripherals().capture_edge(side, cycle, level);
        if told && self.is_powered() {
            self.refresh();
        }
    }

    /// What TIM5, whose captures stamp frames, counts at `at`, by the board's own crystal and without the timer's
    /// rounding. `at` may lie in the past as long as neither the clock tree nor the counter was set since.
    pub fn capture_clock(&self, at: Time) -> f64 {
        self.link.peripherals().capture_clock(self.clock.cycle_at(at))
    }

    /// The debug probe sets the log to blocking mode and is pulled out; nobody reads the log from now on.
    pub fn pull_probe(&mut self) {
        self.drain();
        self.rtt.pull(&mut self.cpu);
    }

    /// FLASH_ACR as the program left it.
    pub fn flash_acr(&self) -> u32 {
        self.link.peripherals().flash().acr()
    }

    /// Level of a pin as its port sees it.
    pub fn pin_level(&self, pin: Pin) -> bool {
        self.link.peripherals().pin_level(pin)
    }

    /// What a CAN controller did since power-on.
    pub fn can_stats(&self, side: Side) -> Stats {
        self.link.peripherals().can().stats(side)
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
        self.link.peripherals().take_pin_changes()
    }

    /// Log lines since the last call.
    pub fn take_log(&mut self) -> Vec<Line> {
        std::mem::take(&mut self.log)
    }

    /// Whether it has power.
    pub fn is_powered(&self) -> bool {
        self.state != State::Off
    }

    /// The transceiver that a controller is connected with, named by the controller whose bus it is on.
    pub(crate) fn transceiver(&self, controller: Side) -> Option<Side> {
        match self.config.fittings.transceiver_switch {
            None => Some(controller),
            Some(_) if controller == Side::Can2 => None,
            Some(pin) if self.link.peripherals().pin_level(pin) => Some(Side::Can2),
            Some(_) => Some(Side::Can1),
        }
    }

    pub(crate) fn link(&self) -> &Arc<Link> {
        &self.link
    }

    fn start(&mut self, cause: ResetCause) {
        self.drain();
        self.interrupt_flash();
        self.rtt.reset(&mut self.cpu);
        self.cpu.reset();
        self.link.peripherals().reset(self.clock.now().time, cause);
        self.admitted_before = self.admitted_in_all();
        self.link.accelerator().reset();
        self.lines = [0; 3];
        self.asleep = false;
        self.panicked = false;
        self.clocks = None;
        self.state = State::Running;
        self.refresh();
    }

    /// The next instant at which the board does something if no wire disturbs it; zero while its core is awake.
    pub fn next_event(&self) -> Time {
        match self.state {
            State::Off => Time::NEVER,
            State::Running if !self.asleep && !self.is_stalled() => Time::ZERO,
            _ => {
                let can = self.link.peripherals().can().next_event().unwrap_or(Time::NEVER);
                let event = match self.state {
                    State::Running => self.wake_event(),
                    State::Refused(_) => u64::MAX,
                    _ => self.watchdog.map_or(u64::MAX, |(_, cycle)| cycle),
                };
                let timer = if event == u64::MAX { Time::NEVER } else { self.clock.time_at(event) };
                can.min(timer)
            }
        }
    }

    /// Where the board stands; it may have run past the instant asked for by the rest of an instruction.
    pub fn now(&self) -> Time {
        self.clock.now().time
    }

    /// Runs until `until` is reached.
    ///
    /// # Errors
    /// [`AccessError`] when the program reached for something that is not there; the board stays stopped.
    pub fn run_until(&mut self, until: Time) -> Result<(), AccessError> {
        loop {
            let result = self.run(until);
            match self.state {
                State::Off => self.clock.jump_to(until),
                State::Running => {}
                // Nobody feeds the watchdog of a core that is gone.
                State::Stuck | State::LockedUp | State::Halted => match self.watchdog {
                    Some((_, cycle)) if self.clock.time_at(cycle) < until => {
                        self.clock.advance_to_cycle(cycle);
                        self.on_event();
                        continue;
                    }
                    _ => self.clock.advance_to(until),
                },
                State::Refused(_) => self.clock.advance_to(until),
            }
            return result;
        }
    }

    fn run(&mut self, until: Time) -> Result<(), AccessError> {
        let before = self.counters.instructions;
        while self.state == State::Running && self.now() < until {
            if self.asleep || self.is_stalled() {
                self.sleep(until);
            } else {
                self.step()?;
                self.skip_turns(until);
            }
        }
        if self.counters.instructions != before {
            if self.state == State::Running && self.cpu.is_locked_up() {
                self.counters.lockups += 1;
                self.state = State::LockedUp;
            }
            self.drain();
        }
        Ok(())
    }

    /// The cycle at which a core that sleeps or waits for its flash may go on.
    fn wake_event(&self) -> u64 {
        // A stalled core cannot take the exception.
        if self.is_stalled() { self.timer_event } else { self.timer_event.min(self.systick) }
    }

    fn sleep(&mut self, until: Time) {
        let event = self.wake_event();
        if event == u64::MAX || self.clock.time_at(event) > until {
            self.clock.advance_to(until);
            return;
        }
        self.clock.advance_to_cycle(event);
        // The next step of the core finds its exception pending.
        self.asleep &= event < self.systick;
        if event >= self.timer_event {
            self.on_event();
        }
    }

    /// The cycle of `timer_event` has come.
    fn on_event(&mut self) {
        if self.watchdog.is_some_and(|(_, cycle)| cycle <= self.clock.now().cycle) {
            self.counters.watchdog_resets += 1;
            self.start(ResetCause::Watchdog);
        } else if self.flash.event() <= self.clock.now().cycle {
            self.on_flash_event();
        } else {
            self.refresh();
        }
    }

    fn step(&mut self) -> Result<(), AccessError> {
        self.link.set_now(self.clock.now());
        let step = self.cpu.step();
        self.clock.advance(step.cycles);
        self.counters.instructions += 1;
        self.counters.cycles_awake += u64::from(step.cycles);
        self.asleep = step.asleep;
        self.systick = step.systick;
        self.spin.follow(step);
        if self.link.take_touched() {
            if let Some(refused) = self.link.take_refused() {
                return Err(self.refuse(refused));
            }
            self.refresh();
        }
        if step.asleep && self.cpu.sleeps_deeply() {
            return Err(self.refuse_deep_sleep());
        }
        self.look_after(step)?;
        if self.clock.now().cycle >= self.timer_event {
            self.on_event();
        }
        Ok(())
    }

    fn look_after(&mut self, step: Step) -> Result<(), AccessError> {
        if let Some(refused) = step.refused {
            return Err(self.refuse_instruction(refused));
        }
        if step.hard_fault {
            if let Some(address) = self.cpu.take_bus_fault()
                && !self.config.model.part.is_reserved(address)
            {
                let refused = RefusedAccess { address, write: false, refusal: Refusal::Unmodelled };
                return Err(self.refuse(refused));
            }
            self.drain();
            if !self.panicked {
                self.counters.panics += 1;
                self.panicked = true;
            }
        }
        if step.stuck {
            self.state = State::Stuck;
        }
        if step.breakpoint {
            self.drain();
            // What the program freezes beside the core runs on where the model does not stop it.
            self.state = State::Halted;
            let now = self.now();
            self.link.peripherals().halt(now);
            self.refresh();
        }
        if step.reset_request {
            self.counters.system_resets += 1;
            self.start(ResetCause::Software);
        }
        Ok(())
    }

    /// Follows what the peripherals did: clock tree, interrupt lines, next timer event.
    pub(crate) fn refresh(&mut self) {
        self.spin.end();
        let link = self.link.clone();
        let mut peripherals = link.peripherals();
        peripherals.run_timers(self.clock.now().cycle);
        self.edges.extend(peripherals.take_timed_changes().into_iter().map(|change| {
            let (at, fraction) = self.clock.exact_time_at(change.cycle);
            Edge { at, fraction, pin: change.pin, high: change.high }
        }));
        let sent = peripherals.take_sent();
        let clocks = peripherals.clocks();
        if !sent.is_empty() {
            self.keep_serial(sent, clocks.hclk);
        }
        let clocks_changed = self.clocks != Some(clocks);
        if clocks_changed {
            self.clocks = Some(clocks);
            let pclk1 = self.clock.set(clocks);
            peripherals.set_clocks(self.clock.now().cycle, clocks, pclk1);
        }
        let now = self.clock.now();
        // Timers raise requests, requests move data, data moved changes flags.
        let mut levels = peripherals.irq_levels(now);
        if peripherals.transfer(now, &mut DmaMemory(&mut self.cpu)) {
            levels = peripherals.irq_levels(now);
        }
        let nmi = peripherals.nmi();
        if nmi != self.nmi {
            self.nmi = nmi;
            self.cpu.set_nmi(nmi);
            self.asleep &= !nmi;
        }
        self.follow_watchdog(peripherals.watchdog_deadline(), clocks_changed);
        let calendar = peripherals.calendar_event().map_or(u64::MAX, |at| self.clock.cycle_at(at) + 1);
        self.follow_flash(peripherals.flash().operation(), clocks_changed);
        let watchdog = self.watchdog.map_or(u64::MAX, |(_, cycle)| cycle);
        self.timer_event = peripherals
            .next_timer_event(now)
            .unwrap_or(u64::MAX)
            .min(watchdog)
            .min(self.flash.event())
            .min(calendar);
        for (word, (&new, old)) in levels.iter().zip(&mut self.lines).enumerate() {
            let mut changed = new ^ *old;
            while changed != 0 {
                let bit = changed.trailing_zeros();
                changed &= changed - 1;
                let level = new >> bit & 1 == 1;
                self.cpu.set_irq((word * 32) as u16 + bit as u16, level);
                // A masked interrupt does not wake the core: the next step finds out.
                self.asleep &= !level;
            }
            *old = new;
        }
    }

    fn follow_watchdog(&mut self, deadline: Option<Time>, clocks_changed: bool) {
        if clocks_changed || deadline != self.watchdog.map(|(at, _)| at) {
            // The first cycle that does not begin before the deadline.
            self.watchdog = deadline.map(|at| (at, self.clock.cycle_at(at) + 1));
        }
    }

    fn drain(&mut self) {
        let first = self.log.len();
        let at = self.now();
        self.rtt.drain(&mut self.cpu, &self.config.image, at, &mut self.log);
        let panics = self.log[first..].iter().filter(|line| line.text.contains("panicked at")).count();
        self.panicked |= panics > 0;
        self.counters.panics += panics as u64;
    }
}
