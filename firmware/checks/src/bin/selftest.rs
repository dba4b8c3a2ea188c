//! Checks a board that is connected to no bus. Logs each result, and shows the overall result by the LEDs.
//!
//! `cargo xtask selftest` flashes it. Both LEDs on: all checks passed. Otherwise they blink the number of the first
//! check that failed, pause, and repeat. Checks 4 to 7 send one frame on each bus.

#![cfg_attr(target_os = "none", no_std, no_main)]

// The board that the image is built for.
#[cfg(all(target_os = "none", feature = "nucleo-f446re"))]
extern crate nucleo_f446re as board;
#[cfg(all(target_os = "none", feature = "pyboard-v11"))]
extern crate pyboard_v11 as board;
#[cfg(all(target_os = "none", feature = "stm32f4discovery"))]
extern crate stm32f4discovery as board;

#[cfg(not(target_os = "none"))]
fn main() {
    println!("This is firmware: cargo xtask selftest");
}

#[cfg(target_os = "none")]
mod firmware {
    use board::Spec;
    use ecss_can::profile::Profile;
    use ecss_can::runner::Platform;
    use ecss_can_runtime::Irqs;
    use ecss_can_stm32f4::{Board, CaptureFault, ControllerTiming, Leds, LineFault};
    use embassy_executor::Spawner;
    use embassy_time::Timer;

    type Port = <Board<Spec> as Platform>::Port;

    /// Failed checks, a bit for each.
    struct Failures(u16);

    impl Failures {
        /// Reports a result. `advice`: part to check if the check failed.
        fn note<E: defmt::Format>(&mut self, number: u8, name: &str, advice: &str, result: Result<(), E>) {
            match result {
                Ok(()) => defmt::info!("{=u8} {=str}: good", number, name),
                Err(found) => {
                    defmt::error!("{=u8} {=str}: {}; {=str}", number, name, found, advice);
                    self.0 |= 1 << number;
                }
            }
        }

        /// Reports transceiver and capture wire of a bus. Without an echo the capture wire is not checked.
        fn note_line(
            &mut self,
            number: u8,
            names: [&str; 2],
            line: Result<Result<(), CaptureFault>, LineFault>,
        ) {
            self.note(
                number,
                names[0],
                "look at its supply, at CAN_TX and CAN_RX, and at CANH and CANL for a short",
                line.map(drop),
            );
            match line {
                Ok(captured) => self.note(
                    number + 2,
                    names[1],
                    "look at the wire from CAN_RX to the capture pin",
                    captured,
                ),
                Err(_) => defmt::warn!("{=u8} {=str}: not checked", number + 2, names[1]),
            }
        }

        fn first(&self) -> Option<u32> {
            (self.0 != 0).then(|| self.0.trailing_zeros())
        }
    }

    fn check_controllers(failures: &mut Failures, nominal: &mut Port, redundant: &mut Port) {
        const CHIP: &str = "the controller itself fails: replace the chip";
        failures.note(2, "controller of the nominal bus", CHIP, nominal.check_controller());
        failures.note(3, "controller of the redundant bus", CHIP, redundant.check_controller());
        let names = ["transceiver of the nominal bus", "capture of the nominal bus"];
        failures.note_line(4, names, nominal.check_line(redundant));
        let names = ["transceiver of the redundant bus", "capture of the redundant bus"];
        failures.note_line(5, names, redundant.check_line(nominal));
    }

    async fn show(mut leds: Leds, failed: Option<u32>) -> ! {
        let mut light = |is_on: bool| {
            let level =
                if is_on { embassy_stm32::gpio::Level::High } else { embassy_stm32::gpio::Level::Low };
            leds.sync.set_level(level);
            leds.state.set_level(level);
        };
        loop {
            let Some(number) = failed else {
                light(true);
                core::future::pending::<()>().await;
                continue;
            };
            for _ in 0..number {
                light(true);
                Timer::after_millis(200).await;
                light(false);
                Timer::after_millis(300).await;
            }
            Timer::after_millis(1_500).await;
        }
    }

    #[embassy_executor::main]
    async fn main(_spawner: Spawner) {
        const TIMING: ControllerTiming = ecss_can_stm32f4::bit_timing(&Profile::DEFAULT.network);
        let p = ecss_can_stm32f4::start::<Spec>();
        let Board { connection, leds, straps, hardware, .. } =
            Board::<Spec>::new(board::take!(p), TIMING, Irqs);
        let mut failures = Failures(0);
        failures.note(
            1,
            "clock",
            "look at the oscillator and its solder bridges",
            ecss_can_stm32f4::check_clock::<Spec>(),
        );
        let mut ports = connection.ports;
        check_controllers(&mut failures, &mut ports.nominal, &mut ports.redundant);
        failures.note(
            8,
            "parameter store",
            "the flash fails: replace the chip",
            hardware.store.ok_or("no store").map(drop),
        );
        failures.note(
            9,
            "straps",
            "an odd number is to be closed, unless this is the master",
            straps.map(drop),
        );
        if let Ok(node) = straps {
            defmt::info!("this board is node {=u8}", node.get());
        }
        match ecss_can_stm32f4::brown_out_level() {
            0 => defmt::info!("brown-out level: 0, as it is to be at 3.3 V"),
            level => defmt::warn!("brown-out level: {=u8}; set 0 at 3.3 V", level),
        }
        match failures.first() {
            None => defmt::info!("selftest: all good"),
            Some(number) => defmt::error!("selftest: failed, first in check {=u32}", number),
        }
        show(leds, failures.first()).await
    }
}
