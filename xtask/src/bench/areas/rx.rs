//! Latency from the receive interrupt to the node and to its application, in cycles.
//!
//! A foreign controller sends 1,000 commands to an operational slave while the twin runs one instruction at a time.
//! Time is the core's count of cycles awake. It starts with the exception entry of the receive interrupt of CAN1 (IPSR
//! becomes 36) and stops after the instruction that counts the frame in `DIAGNOSTICS`: as handled by the node, which
//! has then taken the PDO's value, or as a command that the application has executed. The figure includes all other
//! work of the board in between, such as interrupts. It is measured with zero wait states, with the flash settings of
//! boards, and without the accelerator of the flash.
//!
//! A [sweep](crate::bench::sweep) adds commands that arrive while the board does timed actions. The worst of both is
//! the figure.

use can_twin::board::FlashTiming;
use can_twin::spacecraft::Bus;
use can_twin::wire::encode::encode;
use can_twin::wire::frame::WireFrame;
use can_twin::wire::time::Time;
use ecss_can_cli::images::support::board::Profile;

use crate::bench::context::Context;
use crate::bench::rig::{FLASH_TIMINGS, Rig};
use crate::bench::row::Row;
use crate::bench::sweep::series;

/// Number of measured commands.
const COMMANDS: u32 = 1_000;

/// Time between two commands, a prime number of microseconds, so that the phase to the board's timers varies.
const SPACING: Time = Time::from_us(7_919);

/// Slightly less than the time from SOF to the last bit but one of EOF of a frame of eight bytes without stuff bits.
const ON_THE_WIRE: Time = Time::from_us(104);

/// Node-ID of the slave.
const SLAVE: u8 = 2;

/// "Set value", four bytes, a zero and the sequence (profile `mission`).
const SET_VALUE: [u8; 2] = [0x02, 0x00];

/// COB-ID of the slave's commands.
const COMMAND: u16 = 0x300 + SLAVE as u16;

/// Cycles from the entry of the interrupt.
struct Latency {
    node: u64,
    application: u64,
}

pub fn measure(context: &Context) -> anyhow::Result<Vec<Row>> {
    let cases = FLASH_TIMINGS.into_iter().map(|(timing, name)| measure_with(context, timing, name));
    Ok(cases.collect::<anyhow::Result<Vec<_>>>()?.concat())
}

fn measure_with(context: &Context, timing: FlashTiming, case: &str) -> anyhow::Result<Vec<Row>> {
    let mut rig = Rig::with_flash(context, Profile::Standard, SLAVE, timing)?;
    let series = series(&mut rig, (COMMANDS, SPACING), duration, command)?;
    let (node, application) = (series.cycles(|it| it.node), series.cycles(|it| it.application));
    let row = |name: &str, cycles: u64| Row::lower(format!("{name}{case}"), cycles, "model_cycles");
    // Targets: the worst case is within the shortest frame that can follow, 47 bits. The median is lower.
    let (worst, median) = match timing {
        FlashTiming::Ideal => (None, Some(1_500_u64)),
        FlashTiming::AsSet => (Some(7_896_u64), Some(2_200)),
        FlashTiming::Unaccelerated => (None, None),
    };
    Ok(vec![
        row("interrupt_to_dictionary", node.worst).within_any(worst),
        row("interrupt_to_dictionary_median", node.median).within_any(median),
        row("inside_look", node.swept),
        row("interrupt_to_application", application.worst),
        row("interrupt_to_application_median", application.median),
    ])
}

/// Returns a command with this value.
fn set_value(value: u32) -> Vec<u8> {
    [&SET_VALUE[..], &value.to_le_bytes(), &[0, value as u8]].concat()
}

/// Returns the time from SOF to the last bit but one of EOF, when the receiver has the frame.
fn duration(value: u32) -> Time {
    let frame = WireFrame::standard(COMMAND, &set_value(value));
    Time::from_us(encode(&frame).bits().len() as u64 - 1)
}

/// Sends a command at `at` and follows it through the board.
fn command(rig: &mut Rig, at: Time, value: u32) -> anyhow::Result<Latency> {
    rig.send(Bus::Nominal, at, (COMMAND, &set_value(value)));
    rig.run_until(at + ON_THE_WIRE)?;
    follow(rig)
}

/// Follows the next frame through the board.
fn follow(rig: &mut Rig) -> anyhow::Result<Latency> {
    let (frames, commands) = (rig.diagnostics()?.frames(), rig.commands()?);
    let mut handled = None;
    rig.follow(|rig, cycles| {
        if handled.is_none() && rig.diagnostics()?.frames() > frames {
            handled = Some(cycles);
        }
        let Some(node) = handled else { return Ok(None) };
        Ok((rig.commands()? > commands).then_some(Latency { node, application: cycles }))
    })
}
