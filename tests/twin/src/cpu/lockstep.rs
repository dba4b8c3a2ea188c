//! Lock-step of two cores: [`CortexM4`] leads on the board, `rsemu` follows on a record of its accesses.
//!
//! After each step all registers, the masks, the active exceptions, the sleep state and the cycles are compared. S0 to S31 and FPSCR are
//! compared after steps that can change them and every 256 steps. Differences of known kinds are counted, and the follower adopts the
//! state of the leader. Figures go to the directory that `TWIN_LOCKSTEP` names, one file for each board.

mod differences;

use std::collections::BTreeMap;
use std::fmt::Write;
use std::path::PathBuf;
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};

use twin_core::View;

use super::cortex_m4::CortexM4;
use super::follower::{Follower, Tape};
use super::{Cpu, NotMemory, Registers, Step};
use crate::link::Link;
use crate::model::Part;
use differences::{After, Before, Kind};

const SYSTICK: u32 = 1 << 15;
const NMI: u32 = 1 << 2;
const WFE: u16 = 0xBF20;
const EXCEPTION: u32 = 0x1FF;

/// What was seen of one kind.
#[derive(Default)]
struct Seen {
    count: u64,
    example: String,
}

pub(super) struct LockStep {
    part: Part,
    leader: CortexM4,
    follower: Follower,
    tape: Arc<Tape>,
    /// Where figures go.
    directory: PathBuf,
    image: u64,
    steps: u64,
    resets: u64,
    /// The next step is the reset sequence.
    starts: bool,
    fp_compared: u64,
    kinds: BTreeMap<Kind, Seen>,
    rose: u128,
    lines: u128,
    nmi: bool,
}

fn fnv(bytes: &[u8]) -> u64 {
    bytes
        .iter()
        .fold(0xCBF2_9CE4_8422_2325, |hash, &byte| (hash ^ u64::from(byte)).wrapping_mul(0x100_0000_01B3))
}

impl LockStep {
    pub fn new(part: Part, image: &[u8], link: Arc<Link>, directory: PathBuf) -> Self {
        let tape = Arc::new(Tape::default());
        let mut leader = CortexM4::new(part, image, link.clone());
        leader.memories.tape = Some(tape.clone());
        let end = image.iter().rposition(|&byte| byte != 0xFF).map_or(0, |last| last + 1);
        LockStep {
            part,
            follower: Follower::new(part, image, tape.clone(), link.now().cycle),
            leader,
            tape,
            directory,
            image: fnv(&image[..end.min(0x8000)]),
            steps: 0,
            resets: 0,
            starts: true,
            fp_compared: 0,
            kinds: BTreeMap::new(),
            rose: 0,
            lines: 0,
            nmi: false,
        }
    }

    fn see(&mut self, kind: Kind, example: impl FnOnce() -> String) {
        let steps = self.steps;
        let seen = self.kinds.entry(kind).or_default();
        seen.count += 1;
        if seen.count <= 3 {
            let _ = write!(seen.example, " [step {steps}: {}]", example());
        }
    }

    /// SysTick, its pending bit, that of the NMI, and the cycle counter become those of the leader.
    fn align(&mut self, view: &View) {
        let now = self.leader.core.cycle();
        let deadline = self.leader.core.systick_event();
        let due = now >= deadline;
        let mut seen = Vec::new();
        let [csr, reload, count] = view.systick;
        let nmi_again = self.nmi && view.active[0] & NMI != 0;
        self.follower.cpu.with_sys(|sys| {
            let old = [sys.syst_csr, sys.syst_rvr, sys.syst_cvr];
            if old != view.systick {
                let period = u64::from(reload) + 1;
                let ahead = (u64::from(count) + period - u64::from(old[2])) % period;
                let kind = match () {
                    () if (old[0] ^ csr) & 7 != 0 || old[1] != reload => Kind::Unknown,
                    () if csr & 4 == 0 => Kind::SysTickReference,
                    () if reload == 0 => Kind::SysTickWithoutReload,
                    () if ahead.min(period - ahead) <= 16 => Kind::SysTickAhead,
                    () => Kind::Unknown,
                };
                seen.push((kind, format!("SysTick {:X?} old {old:X?}", view.systick)));
                [sys.syst_csr, sys.syst_rvr, sys.syst_cvr] = view.systick;
            }
            let (pending, was) = (due || view.pending[0] & SYSTICK != 0, sys.pending[0] & SYSTICK != 0);
            if pending != was {
                let kind = match was {
                    _ if csr & 4 == 0 => Kind::SysTickReference,
                    true if deadline - now <= 16 => Kind::SysTickPendedEarly,
                    _ if reload == 0 => Kind::SysTickWithoutReload,
                    _ => Kind::Unknown,
                };
                seen.push((
                    kind,
                    format!("SysTick pending: {pending}, due in {}", deadline.wrapping_sub(now)),
                ));
                sys.pending[0] = sys.pending[0] & !SYSTICK | if pending { SYSTICK } else { 0 };
            }
            sys.pending[0] = sys.pending[0] & !NMI | view.pending[0] & NMI;
            if sys.dwt_cyccnt != view.cyccnt {
                seen.push((Kind::CycleCounter, format!("CYCCNT {} old {}", view.cyccnt, sys.dwt_cyccnt)));
                sys.dwt_cyccnt = view.cyccnt;
            }
        });
        for (kind, example) in seen {
            self.see(kind, || example);
        }
        if nmi_again {
            self.see(Kind::NmiAgain, || "line high in the handler".to_owned());
        }
    }

    fn follow(&mut self, before: &Before, step: Step) {
        let waits = u64::from(self.leader.memories.last_waits);
        let cycles = u64::from(step.cycles) - waits;
        let old_cycles = self.follower.step();
        let registers = self.leader.core.registers();
        let view = self.leader.core.view();
        let regs = self.follower.cpu.regs();
        let exception_changed = (registers.xpsr ^ before.registers.xpsr) & EXCEPTION != 0;
        let after = After { registers, view, cycles, old: regs, old_cycles, problem: self.problem() };
        let active = self.follower.cpu.with_sys(|sys| {
            let rest = sys.active[4..].iter().all(|&word| word == 0);
            (sys.active[..4] == view.active && rest).then_some(()).ok_or_else(|| format!("{:X?}", sys.active))
        });
        let asleep = self.follower.cpu.is_asleep();
        let locked_up = self.follower.cpu.is_locked_up();
        if self.starts {
            self.starts = false;
            self.resets += 1;
            let same =
                (regs.r[13], regs.r[15], regs.xpsr) == (registers.r[13], registers.r[15], registers.xpsr);
            let kind = if same && after.problem.is_none() { Kind::AfterReset } else { Kind::Unknown };
            self.see(kind, || format!("LR {:X} old {:X}", registers.r[14], regs.r[14]));
            self.follower.adopt(&registers, &view);
            self.settle(before, &after);
            return;
        }
        let mut difference = after.differs();
        if let Err(active) = active {
            difference
                .get_or_insert_with(String::new)
                .push_str(&format!(" active {:X?} old {active}", view.active));
        }
        if asleep != step.asleep {
            difference
                .get_or_insert_with(String::new)
                .push_str(&format!(" asleep {} old {asleep}", step.asleep));
        }
        if locked_up != view.locked_up {
            difference.get_or_insert_with(String::new).push_str(" lock-up");
        }
        let coprocessor = matches!(before.code >> 16, 0xEC00..=0xEFFF | 0xFC00..=0xFFFF);
        if difference.is_none() && (coprocessor || exception_changed || self.steps.is_multiple_of(256)) {
            self.fp_compared += 1;
            let s = std::array::from_fn(|register| self.follower.cpu.s(register as u8));
            let fpscr = self.follower.cpu.fpscr();
            if s != registers.s || fpscr != registers.fpscr {
                difference = Some(format!(
                    "FPSCR {:X} old {fpscr:X}, S {:X?} old {s:X?}",
                    registers.fpscr, registers.s
                ));
            }
        }
        if let Some(difference) = difference {
            let kind = differences::kind(before, &after, asleep, &difference);
            self.see(kind, || format!("{before}: {difference}"));
            self.adopt(&after);
        } else if let Some(problem) = &after.problem {
            let kind = differences::kind_of_access(before, &after);
            self.see(kind, || format!("{before}: access {problem}"));
            self.adopt(&after);
        }
        if cycles != old_cycles {
            let kind = differences::kind_of_cycles(before, &after);
            self.see(kind, || format!("{before}: {cycles} cycles, old {old_cycles}"));
        }
        if exception_changed {
            self.compare_frame(before, &after);
        }
        self.settle(before, &after);
    }

    fn settle(&mut self, before: &Before, after: &After) {
        self.follower.settle(before.cycle + after.cycles);
    }

    fn problem(&self) -> Option<String> {
        let mut tape = self.tape.lock().expect("no panic under this lock");
        let left = tape.accesses.pop_front();
        tape.accesses.clear();
        tape.flash.clear();
        tape.problem.take().or_else(|| left.map(|left| format!("left: {left:X?}")))
    }

    /// The stack at an exception entry or return.
    fn compare_frame(&mut self, before: &Before, after: &After) {
        let registers = &after.registers;
        let process = registers.xpsr & EXCEPTION != 0 && registers.r[14] & 4 != 0;
        let frame = if process { registers.other_sp } else { registers.r[13] };
        let (mut new, mut old) = ([0; 0x20], [0; 0x20]);
        if self.leader.memories.copy_out(frame, &mut new).is_err()
            || !self.follower.read_memory(frame, &mut old)
        {
            if self.follower.ram() != self.leader.memories.ram()
                || self.follower.ccm() != self.leader.memories.ccm()
            {
                self.see(Kind::StackingFault, || format!("{before}: frame at {frame:X}"));
                self.adopt(after);
            }
            return;
        }
        if new != old {
            let kind = differences::kind_of_frame(before, &new, &old);
            self.see(kind, || format!("{before}: frame {new:02X?} old {old:02X?}"));
            self.follower.write_memory(frame, &new);
        }
    }

    fn adopt(&mut self, after: &After) {
        self.follower.adopt(&after.registers, &after.view);
        let (ram, ccm) = (self.leader.memories.ram(), self.leader.memories.ccm());
        self.follower.write_memory(0x2000_0000, ram);
        self.follower.write_memory(0x1000_0000, ccm);
    }
}

impl Cpu for LockStep {
    fn step(&mut self) -> Step {
        let now = self.leader.memories.link().now().cycle;
        self.leader.core.advance_to(now);
        let view = self.leader.core.view();
        let registers = self.leader.core.registers();
        let pc = registers.r[15];
        let half = |address| u32::from(self.leader.memories.half_at(address).unwrap_or_default());
        let before = Before {
            cycle: self.leader.core.cycle(),
            registers,
            view,
            code: half(pc) << 16 | half(pc.wrapping_add(2)),
        };
        self.follower.advance(before.cycle);
        self.align(&view);
        if before.code >> 16 == u32::from(WFE) && !view.asleep {
            let event = self.follower.event();
            if event != view.event {
                self.see(Kind::EventRegister, || format!("{before}: event {} old {event}", view.event));
                self.follower.set_event(view.event);
            }
        }
        let step = self.leader.step();
        if step.breakpoint || step.refused.is_some() {
            self.problem();
            return step;
        }
        self.steps += 1;
        self.rose = 0;
        self.follow(&before, step);
        step
    }

    fn set_irq(&mut self, irq: u16, asserted: bool) {
        let bit = 1 << irq;
        let was = self.lines & bit != 0;
        if asserted && !was {
            self.rose |= bit;
            let view = self.leader.core.view();
            let exception = usize::from(irq) + 16;
            if view.active[exception / 32] >> (exception % 32) & 1 == 1 {
                self.see(Kind::EdgeWhileActive, || format!("interrupt {irq}"));
            }
            self.follower.cpu.pend_irq(irq);
        }
        if !asserted && self.rose & bit != 0 {
            self.see(Kind::ShortPulse, || format!("interrupt {irq}"));
        }
        self.lines = if asserted { self.lines | bit } else { self.lines & !bit };
        self.leader.set_irq(irq, asserted);
        self.follower.cpu.set_irq(irq, asserted);
    }

    fn set_nmi(&mut self, asserted: bool) {
        self.nmi = asserted;
        self.leader.set_nmi(asserted);
    }

    fn reset(&mut self) {
        self.leader.reset();
        self.follower.reset();
        self.starts = true;
        (self.lines, self.rose, self.nmi) = (0, 0, false);
    }

    fn is_locked_up(&self) -> bool {
        self.leader.is_locked_up()
    }

    fn pc(&self) -> u32 {
        self.leader.pc()
    }

    fn return_address(&self) -> Option<u32> {
        self.leader.return_address()
    }

    fn take_bus_fault(&mut self) -> Option<u32> {
        self.leader.take_bus_fault()
    }

    fn sleeps_deeply(&self) -> bool {
        self.leader.sleeps_deeply()
    }

    fn enable_debug(&mut self) {
        self.leader.enable_debug();
    }

    fn skip_to(&mut self, cycle: u64) {
        self.leader.skip_to(cycle);
        self.follower.skip_to(cycle);
    }

    fn registers(&self) -> Registers {
        self.leader.registers()
    }

    fn read_memory(&self, address: u32, bytes: &mut [u8]) -> Result<(), NotMemory> {
        self.leader.read_memory(address, bytes)
    }

    fn write_memory(&mut self, address: u32, bytes: &[u8]) -> Result<(), NotMemory> {
        self.leader.write_memory(address, bytes)?;
        self.follower.write_memory(address, bytes);
        Ok(())
    }

    fn write_flash(&mut self, address: u32, bytes: &[u8]) -> Result<(), NotMemory> {
        self.leader.write_flash(address, bytes)?;
        self.follower.write_flash(address, bytes);
        Ok(())
    }
}

impl Drop for LockStep {
    fn drop(&mut self) {
        if self.steps == 0 {
            return;
        }
        static BOARDS: AtomicU64 = AtomicU64::new(0);
        let number = BOARDS.fetch_add(1, Ordering::Relaxed);
        let (ram, ccm) = (self.follower.ram(), self.follower.ccm());
        let same = ram == self.leader.memories.ram() && ccm == self.leader.memories.ccm();
        let first = ram.iter().zip(self.leader.memories.ram()).position(|(old, new)| old != new);
        let mut text = format!(
            "test\t{}\npart\t{:?}\nimage\t{:016x}\nsteps\t{}\nfp\t{}\nresets\t{}\nram\t{:016x}\t{:016x}\t{same}\t{first:X?}\n",
            std::thread::current().name().unwrap_or("?"),
            self.part,
            self.image,
            self.steps,
            self.fp_compared,
            self.resets,
            fnv(self.leader.memories.ram()) ^ fnv(self.leader.memories.ccm()),
            fnv(&ram) ^ fnv(&ccm),
        );
        for (kind, seen) in &self.kinds {
            let _ = writeln!(text, "kind\t{kind:?}\t{}\t{}", seen.count, seen.example);
        }
        let file = self.directory.join(format!("{}-{number}", std::process::id()));
        std::fs::write(file, text).expect("TWIN_LOCKSTEP names a directory");
        let unknown = self.kinds.get(&Kind::Unknown).map_or("", |seen| &seen.example);
        if !std::thread::panicking() {
            assert!(unknown.is_empty(), "the cores differ:{unknown}");
            assert!(same, "the memories differ at {first:X?}");
        }
    }
}
