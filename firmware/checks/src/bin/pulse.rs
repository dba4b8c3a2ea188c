//! Raises the pulse pin every millisecond of the board's uptime, each time a little later within a microsecond.
//!
//! On two boards an oscilloscope shows the pulses drift apart as the crystals do. The twin compares each edge with the
//! requested instant.

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
    println!("This is firmware: cargo run -p checks --bin pulse --profile firmware \\");
    println!("    --target thumbv7em-none-eabihf --features pyboard-v11");
}

#[cfg(target_os = "none")]
mod firmware {
    use core::sync::atomic::{AtomicU32, Ordering};

    use board::Spec;
    use ecss_can::profile::Profile;
    use ecss_can::runner::Clock;
    use ecss_can::types::{Duration, FineInstant};
    use ecss_can_runtime::Irqs;
    use ecss_can_stm32f4::{Board, ControllerTiming, Pulse, Uptime};
    use embassy_executor::Spawner;

    /// Units of a [`FineInstant`] in a millisecond.
    const MILLISECOND: u64 = 1_000 * FineInstant::PER_MICRO;
    /// Added to each millisecond, so that 256 pulses cover each fraction of a microsecond.
    const SHIFT: u64 = 37;

    /// First requested instant, in units (low and high word); number of pulses made; number refused.
    // SAFETY: no other symbol of the image has this name.
    #[unsafe(no_mangle)]
    static REPORT: [AtomicU32; 4] = [const { AtomicU32::new(0) }; 4];

    fn count(at: usize) {
        REPORT[at].store(REPORT[at].load(Ordering::Relaxed) + 1, Ordering::Relaxed);
    }

    async fn run(mut pulse: Pulse) -> ! {
        let now = Uptime.now();
        // Instants that are past, now, and too near for a pulse.
        for at in [now - Duration::from_millis(30_000), now, now + Duration::from_micros(5)] {
            if pulse.at(at.into()).await.is_err() {
                count(3);
            }
        }
        let mut next = FineInstant::from(Uptime.now()).units() + 2 * MILLISECOND;
        REPORT[0].store(next as u32, Ordering::Relaxed);
        REPORT[1].store((next >> 32) as u32, Ordering::Relaxed);
        loop {
            count(if pulse.at(FineInstant::from_units(next)).await.is_ok() { 2 } else { 3 });
            next += MILLISECOND + SHIFT;
        }
    }

    #[embassy_executor::main]
    async fn main(_spawner: Spawner) {
        const TIMING: ControllerTiming = ecss_can_stm32f4::bit_timing(&Profile::DEFAULT.network);
        let p = ecss_can_stm32f4::start::<Spec>();
        let Board { pulse, .. } = Board::<Spec>::new(board::take!(p), TIMING, Irqs);
        run(pulse).await
    }
}
