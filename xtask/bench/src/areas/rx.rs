//! From the receive interrupt to the node and to its application, in cycles.
//!
//! A slave, operational, is sent 1,000 commands by a foreign controller while the twin runs one instruction at a time.
//! The clock is the core's count of cycles awake. It starts with the exception entry of the receive interrupt of CAN1
//! (IPSR becomes 36) and stops after the instruction that counts the frame in `TELLTALE`: as handled by the node, which
//! has taken the PDO's value then, or as a command that the application has executed. Whatever else the board does in
//! between, other interrupts included, is in the figure. Measured with zero wait states, as boards fly, and without the
//! accelerator of the flash.

use can_wire::time::Time;
use twin::board::FlashTiming;
use twin::spacecraft::Bus;

use super::Area;
use crate::context::Context;
use crate::rig::{FLASH_TIMINGS, MASTER_BEATS, Rig};
use crate::row::Row;
use support::board::Profile;

pub const AREA: Area =
    Area { name: "rx", about: "model cycles from receive interrupt to node and application", measure };

/// Commands that are followed.
const COMMANDS: u32 = 1_000;

/// Between two commands: a prime number of microseconds meets the board's timers at ever other moments.
const SPACING: Time = Time::from_us(7_919);

/// From what was before to the heartbeat of the master that comes before each command.
const BREAK: Time = Time::from_us(500);

/// From SOF to the last bit but one of EOF of a frame of eight bytes without stuff bits, and a little less.
const ON_THE_WIRE: Time = Time::from_us(104);

/// Node-ID of the slave.
const SLAVE: u8 = 2;

/// "Set value", four bytes, a zero and the sequence (profile `mission`).
const SET_VALUE: [u8; 2] = [0x02, 0x00];

/// Cycles from the entry of the interrupt.
struct Latency {
    node: u64,
    application: u64,
}

fn measure(context: &Context) -> anyhow::Result<Vec<Row>> {
    let cases = FLASH_TIMINGS.into_iter().map(|(timing, name)| measure_with(context, timing, name));
    Ok(cases.collect::<anyhow::Result<Vec<_>>>()?.concat())
}

/// Most cycles from the interrupt to the dictionary, by design.
fn target(timing: FlashTiming) -> Option<u64> {
    match timing {
        FlashTiming::Ideal => Some(1500),
        FlashTiming::AsSet => Some(2200),
        FlashTiming::Unaccelerated => None,
    }
}

fn measure_with(context: &Context, timing: FlashTiming, case: &str) -> anyhow::Result<Vec<Row>> {
    let mut rig = Rig::with_flash(context, Profile::Standard, SLAVE, timing)?;
    let mut at = rig.spacecraft.now();
    let mut latencies = Vec::new();
    for value in 0..COMMANDS {
        at += SPACING;
        let command = [&SET_VALUE[..], &value.to_le_bytes(), &[0, value as u8]].concat();
        rig.send(Bus::Nominal, rig.spacecraft.now() + BREAK, MASTER_BEATS);
        rig.send(Bus::Nominal, at, (0x300 + u16::from(SLAVE), &command));
        rig.run_until(at + ON_THE_WIRE)?;
        latencies.push(follow(&mut rig)?);
    }
    let [node, application] = [|it: &Latency| it.node, |it: &Latency| it.application].map(|part| {
        let mut cycles: Vec<u64> = latencies.iter().map(part).collect();
        cycles.sort_unstable();
        (cycles[cycles.len() - 1], cycles[cycles.len() / 2])
    });
    let row = |name: &str, cycles: u64| Row::lower(format!("{name}{case}"), cycles, "model_cycles");
    let worst = row("interrupt_to_dictionary", node.0);
    Ok(vec![
        match target(timing) {
            Some(target) => worst.within(target),
            None => worst,
        },
        row("interrupt_to_dictionary_median", node.1),
        row("interrupt_to_application", application.0),
        row("interrupt_to_application_median", application.1),
    ])
}

/// Follows the next frame through the board.
fn follow(rig: &mut Rig) -> anyhow::Result<Latency> {
    let (frames, commands) = (rig.telltale()?.frames(), rig.commands()?);
    let mut handled = None;
    rig.follow(|rig, cycles| {
        if handled.is_none() && rig.telltale()?.frames() > frames {
            handled = Some(cycles);
        }
        let Some(node) = handled else { return Ok(None) };
        Ok((rig.commands()? > commands).then_some(Latency { node, application: cycles }))
    })
}
