//! A debugger that halts the core, and peripherals that continue meanwhile.

use can_twin::board::{HaltError, State};
use can_twin::guest::GuestEvent;
use can_twin::spacecraft::{BoardId, Bus, Spacecraft};
use can_twin::wire::frame::WireFrame;
use can_twin::wire::time::Time;

use super::programs::*;

const DBGMCU_APB1_FZ: u32 = 0xE004_2008;
const IWDG_STOP: u32 = 1 << 12;
const CAN1_STOP: u32 = 1 << 25;
/// DBF of MCR.
const DBF: u32 = 1 << 16;

/// The program copies SysTick's count to RAM without end.
#[test]
fn a_halted_core_and_its_systick_stand_still() {
    let count = [store(SYST_RVR, 0x00FF_FFFF), store(SYST_CVR, 0), store(SYST_CSR, 5)].concat();
    // 10 halfwords to copy, and B back over them: -24 bytes from 4 behind it.
    let forever = [copy(SYST_CVR, RAM), vec![0xE7F4]].concat();
    let program = image(&[count, forever].concat(), &STOP);
    let mut board = flown(board("halted", program), Time::from_us(100));
    let before = (word(&board, RAM), board.registers(), board.counters().instructions);
    board.halt().unwrap();
    assert_eq!(*board.state(), State::Halted);
    board.run_until(Time::from_ms(50)).unwrap();
    assert_eq!((word(&board, RAM), board.registers(), board.counters().instructions), before);
    board.go_on();
    board.run_until(Time::from_us(50_010)).unwrap();
    // 10 us of HSI are 160 cycles, and one turn of the loop takes fewer than 100.
    let passed = before.0 - word(&board, RAM);
    assert!((60..=260).contains(&passed), "{passed}");
}

/// The reference manual: a controller stops when both DBG_CANx_STOP and DBF are set (RM0090 32.5 and 38.16.2).
#[test]
fn a_frozen_controller_leaves_the_bus_until_the_core_goes_on() {
    for (freezes, mcr, acknowledges) in
        [(CAN1_STOP, DBF, false), (CAN1_STOP, 0, true), (0, DBF, true), (0, 0, true)]
    {
        let program =
            [store(DBGMCU_APB1_FZ, freezes), join_both_buses(), store(CAN1, mcr), SLEEP.to_vec()].concat();
        let id = BoardId(0);
        let mut spacecraft = spacecraft([board("halted", image(&program, &STOP))]);
        let guest = spacecraft.add_guest(Bus::Nominal, 1.0);
        spacecraft.run_until(Time::from_ms(4)).unwrap();
        spacecraft.board_mut(id).halt().unwrap();
        spacecraft.inject(guest, Time::from_us(4_100), WireFrame::standard(0x123, &[1]));
        let sent = |spacecraft: &mut Spacecraft, ms| {
            spacecraft.run_until(Time::from_ms(ms)).unwrap();
            heard(spacecraft, guest).iter().filter(|event| matches!(event, GuestEvent::Sent(_))).count()
        };
        assert_eq!(sent(&mut spacecraft, 8), usize::from(acknowledges), "{freezes:X}h, MCR {mcr:X}h");
        spacecraft.board_mut(id).go_on();
        assert_eq!(sent(&mut spacecraft, 12), usize::from(!acknowledges), "{freezes:X}h, MCR {mcr:X}h");
    }
}

/// 512 ms at 32 kHz and reset values; the core is halted for a second in between.
#[test]
fn the_watchdog_bites_a_halted_core_unless_it_is_frozen() {
    for (freezes, resets) in [(0, 1), (IWDG_STOP, 0)] {
        let program = [store(DBGMCU_APB1_FZ, freezes), store(IWDG, 0xCCCC), STOP.to_vec()].concat();
        let mut board = flown(board("halted", image(&program, &STOP)), Time::from_ms(100));
        board.halt().unwrap();
        board.run_until(Time::from_ms(700)).unwrap();
        assert_eq!(board.counters().watchdog_resets, resets);
        if resets == 0 {
            board.run_until(Time::from_ms(1_100)).unwrap();
            board.go_on();
            board.run_until(Time::from_ms(1_500)).unwrap();
            assert_eq!(board.counters().watchdog_resets, 0, "412 ms are left");
            board.run_until(Time::from_ms(1_520)).unwrap();
            assert_eq!(board.counters().watchdog_resets, 1);
        }
    }
}

#[test]
fn a_halt_that_would_stop_timers_is_refused() {
    let program = [store(DBGMCU_APB1_FZ, CAN1_STOP | 1), STOP.to_vec()].concat();
    let mut board = flown(board("halted", image(&program, &STOP)), Time::from_us(100));
    let error = board.halt().unwrap_err();
    assert_eq!(error, HaltError::Unmodelled { board: "halted".into(), frozen: 1, frozen2: 0 });
    assert!(error.to_string().contains("only CAN1, CAN2 and IWDG can stop with the core"), "{error}");
    assert_eq!(*board.state(), State::Running);
    board.power(false);
    assert_eq!(board.halt(), Err(HaltError::NotRunning("halted".into())));
}
