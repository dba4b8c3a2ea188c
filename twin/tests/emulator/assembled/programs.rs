//! Programs assembled by hand, without a toolchain for the part.

use std::sync::Arc;

use can_twin::board::{AccessError, BoardConfig, EmulatedBoard, Fittings, State};
use can_twin::crystal::Crystal;
use can_twin::guest::GuestEvent;
use can_twin::image::Image;
use can_twin::model::Model;
use can_twin::spacecraft::{Bus, GuestId, Spacecraft, SpacecraftConfig, WireRecord};
use can_twin::wire::frame::WireFrame;
use can_twin::wire::record::Observation;
use can_twin::wire::time::Time;

pub const RAM: u32 = 0x2000_0000;
const FLASH: u32 = 0x0800_0000;
const CODE: u32 = FLASH + 0x200;
pub const HANDLER: u32 = FLASH + 0x800;

/// `B .`
pub const STOP: [u16; 1] = [0xE7FE];
/// `WFE; B WFE`
pub const SLEEP: [u16; 2] = [0xBF20, 0xE7FD];
/// `BX lr`
pub const RETURN: [u16; 1] = [0x4770];

/// `MOVW r<d>, #low; MOVT r<d>, #high` (DDI 0403 A7.7.76 T3, A7.7.79 T1).
pub fn load(d: u16, value: u32) -> [u16; 4] {
    let half = |opcode: u16, imm: u32| {
        let imm = imm as u16;
        [opcode | (imm >> 11 & 1) << 10 | imm >> 12, (imm >> 8 & 7) << 12 | d << 8 | imm & 0xFF]
    };
    let ([a, b], [c, e]) = (half(0xF240, value & 0xFFFF), half(0xF2C0, value >> 16));
    [a, b, c, e]
}

/// Stores a word: `r0 = address; r1 = value; STR r1, [r0]`.
pub fn store(address: u32, value: u32) -> Vec<u16> {
    [&load(0, address)[..], &load(1, value), &[0x6001]].concat()
}

/// Copies a word: `r0 = from; LDR r1, [r0]; r0 = to; STR r1, [r0]`.
pub fn copy(from: u32, to: u32) -> Vec<u16> {
    [&load(0, from)[..], &[0x6801], &load(0, to), &[0x6001]].concat()
}

/// Flash with `program` after reset and `handler` for every exception.
pub fn image(program: &[u16], handler: &[u16]) -> Arc<Image> {
    let mut flash = vec![0xFF; 0x1000];
    let mut put = |address: u32, bytes: &[u8]| {
        let at = (address - FLASH) as usize;
        flash[at..at + bytes.len()].copy_from_slice(bytes);
    };
    put(FLASH, &(RAM + 0x1000).to_le_bytes());
    put(FLASH + 4, &(CODE | 1).to_le_bytes());
    for vector in 2..98 {
        put(FLASH + vector * 4, &(HANDLER | 1).to_le_bytes());
    }
    for (base, code) in [(CODE, program), (HANDLER, handler)] {
        for (k, halfword) in code.iter().enumerate() {
            put(base + 2 * k as u32, &halfword.to_le_bytes());
        }
    }
    Arc::new(Image::from_flash(flash))
}

/// A board at the left end of the cable with an exact crystal.
pub fn board(name: &str, image: Arc<Image>) -> BoardConfig {
    BoardConfig {
        name: name.to_owned(),
        model: Model::shipped("pyboard-v11"),
        image,
        straps: Vec::new(),
        crystal: Crystal::ppm(0.0),
        position_m: 0.0,
        power_on_at: Time::ZERO,
        fittings: Fittings::default(),
    }
}

/// A board that has just got power.
pub fn powered(config: BoardConfig) -> EmulatedBoard {
    let mut board = EmulatedBoard::new(config, 0);
    board.power(true);
    board
}

/// A board that has run until `until`.
pub fn flown(config: BoardConfig, until: Time) -> EmulatedBoard {
    let mut board = powered(config);
    board.run_until(until).unwrap();
    board
}

/// The access before `until` that stops a board.
#[track_caller]
pub fn refused(config: BoardConfig, until: Time) -> AccessError {
    let name = config.name.clone();
    let mut board = powered(config);
    let error = board.run_until(until).expect_err(&name);
    assert_eq!(*board.state(), State::Refused(error.clone()));
    error
}

/// Boards on their wires; the first one is `BoardId(0)`.
pub fn spacecraft<const N: usize>(boards: [BoardConfig; N]) -> Spacecraft {
    let mut spacecraft = Spacecraft::new(SpacecraftConfig::default());
    for board in boards {
        spacecraft.add_board(board);
    }
    spacecraft
}

pub fn words<const N: usize>(board: &EmulatedBoard, address: u32) -> [u32; N] {
    let bytes = board.read_memory(address, 4 * N).unwrap();
    std::array::from_fn(|n| u32::from_le_bytes(bytes[4 * n..4 * n + 4].try_into().unwrap()))
}

pub fn word(board: &EmulatedBoard, address: u32) -> u32 {
    let [word] = words(board, address);
    word
}

pub const FLASH_ACR: u32 = 0x4002_3C00;
pub const FLASH_KEYR: u32 = FLASH_ACR + 0x04;
pub const FLASH_SR: u32 = FLASH_ACR + 0x0C;
pub const FLASH_CR: u32 = FLASH_ACR + 0x10;
/// Bit of FLASH_SR.
pub const BSY: u16 = 16;
/// PSIZE in FLASH_CR: words.
pub const X32: u32 = 0b10 << 8;
/// Sector 11 of flash, the last of 1 MiB.
pub const SECTOR: u32 = 0x080E_0000;
/// Value of FLASH_CR that erases this sector.
pub const ERASE: u32 = 1 << 16 | X32 | 11 << 3 | 1 << 1;
pub const RCC: u32 = 0x4002_3800;
pub const GPIOA: u32 = 0x4002_0000;
pub const GPIOB: u32 = 0x4002_0400;
pub const TIM2: u32 = 0x4000_0000;
pub const TIM3: u32 = 0x4000_0400;
pub const TIM5: u32 = 0x4000_0C00;
pub const DMA1: u32 = 0x4002_6000;
pub const IWDG: u32 = 0x4000_3000;
pub const SYST_CSR: u32 = 0xE000_E010;
pub const SYST_RVR: u32 = 0xE000_E014;
pub const SYST_CVR: u32 = 0xE000_E018;
pub const NVIC_ISER0: u32 = 0xE000_E100;
pub const DEMCR: u32 = 0xE000_EDFC;
pub const DWT_CTRL: u32 = 0xE000_1000;
pub const CYCCNT: u32 = 0xE000_1004;

/// HSE 12 MHz: 168 MHz.
pub fn run_at_168_mhz() -> Vec<u16> {
    run_at_168_mhz_from(12)
}

/// Program that starts HSE of `hse_mhz` MHz, divided by PLL M to 2 MHz, N = 168, P = 2, AHB 1, APB1 4, APB2 2: 168 MHz
/// once the PLL has locked, with 5 wait states.
pub fn run_at_168_mhz_from(hse_mhz: u32) -> Vec<u16> {
    [
        store(FLASH_ACR, 5),
        store(RCC + 0x04, 7 << 24 | 1 << 22 | 168 << 6 | (hse_mhz / 2)),
        store(RCC, 0x0001_0083),
        wait_for(RCC, 17),
        store(RCC, 0x0101_0083),
        wait_for(RCC, 25),
        store(RCC + 0x08, 4 << 13 | 5 << 10 | 2),
    ]
    .concat()
}

/// Opens the lock of flash.
pub fn unlock() -> Vec<u16> {
    [store(FLASH_KEYR, 0x4567_0123), store(FLASH_KEYR, 0xCDEF_89AB)].concat()
}

/// Spins until a bit is set: `r0 = address; LDR r1, [r0]; LSLS r1, r1, #(31 - bit); BPL .-4`.
pub fn wait_for(address: u32, bit: u16) -> Vec<u16> {
    [&load(0, address)[..], &[0x6801, (31 - bit) << 6 | 1 << 3 | 1, 0xD5FC]].concat()
}

/// Spins until a bit is clear.
pub fn wait_for_clear(address: u32, bit: u16) -> Vec<u16> {
    [&load(0, address)[..], &[0x6801, (31 - bit) << 6 | 1 << 3 | 1, 0xD4FC]].concat()
}

/// A captured line: TIM5 channel and pin of port A, 0 to 3; stream of DMA1; address of its ring of four words.
pub type CapturedLine = (u32, u32, u32);

/// Captures both edges of two lines at 84 MHz, each by its stream on channel 6. The stream interrupts at the end of its ring and at
/// a bus error.
pub fn capture(hse_mhz: u32, lines: [CapturedLine; 2]) -> Vec<u16> {
    let bits = |bits: u32, per_channel: u32| {
        lines.iter().fold(0, |all, (channel, ..)| all | bits << (per_channel * channel))
    };
    let stream = |(channel, stream, ring): CapturedLine| {
        let base = DMA1 + 0x10 + 0x18 * stream;
        // CHSEL 6, MSIZE and PSIZE word, MINC, CIRC, TCIE, TEIE; then EN.
        let cr = 6 << 25 | 2 << 13 | 2 << 11 | 1 << 10 | 1 << 8 | 1 << 4 | 1 << 2;
        [
            store(base + 0x08, TIM5 + 0x34 + 4 * channel),
            store(base + 0x0C, ring),
            store(base + 0x04, 4),
            store(base + 0x14, 0),
            store(base, cr),
            store(base, cr | 1),
        ]
        .concat()
    };
    let modes = bits(1, 8);
    [
        run_at_168_mhz_from(hse_mhz),
        store(RCC + 0x30, 1 << 21 | 1 << 0),
        store(RCC + 0x40, 1 << 3),
        store(GPIOA + 0x20, bits(2, 4)),
        store(GPIOA, 0xA800_0000 | bits(2, 2)),
        store(TIM5 + 0x18, modes & 0xFFFF),
        store(TIM5 + 0x1C, modes >> 16),
        store(TIM5 + 0x20, bits(0xB, 4)),
        store(TIM5 + 0x0C, bits(1 << 9, 1)),
        lines.map(stream).concat(),
        store(TIM5, 1),
    ]
    .concat()
}

pub const CAN1: u32 = 0x4000_6400;
pub const CAN2: u32 = 0x4000_6800;

/// 1 Mbit/s at 42 MHz PCLK1: BRP 2, TS1 9, TS2 2.
pub const MEGABIT: u32 = 2 << 20 | 9 << 16 | 2;

/// Both controllers on the pins of our boards at 1 Mbit/s, every frame into FIFO 0.
pub fn join_both_buses() -> Vec<u16> {
    let pins =
        [store(RCC + 0x30, 1 << 1), store(GPIOB + 0x24, 0x0099_0099), store(GPIOB, 0x0A0A_0280)].concat();
    [start_both_controllers(&pins), join(CAN1, MEGABIT), join(CAN2, MEGABIT)].concat()
}

/// Clocks, `pins`, and filters that put every frame into FIFO 0; both controllers sleep.
pub fn start_both_controllers(pins: &[u16]) -> Vec<u16> {
    [
        &run_at_168_mhz()[..],
        pins,
        &store(RCC + 0x40, 1 << 25 | 1 << 26),
        // Filter bank 0 for CAN1, bank 14 for CAN2: 32-bit masks of zero.
        &store(CAN1 + 0x200, 14 << 8 | 1),
        &store(CAN1 + 0x20C, 1 << 14 | 1),
        &store(CAN1 + 0x240, 0),
        &store(CAN1 + 0x244, 0),
        &store(CAN1 + 0x240 + 14 * 8, 0),
        &store(CAN1 + 0x244 + 14 * 8, 0),
        &store(CAN1 + 0x21C, 1 << 14 | 1),
        &store(CAN1 + 0x200, 14 << 8),
    ]
    .concat()
}

/// Takes a controller through initialisation with this BTR to Normal mode.
pub fn join(can: u32, btr: u32) -> Vec<u16> {
    [store(can, 1), wait_for(can + 4, 0), store(can + 0x1C, btr), store(can, 0), wait_for_clear(can + 4, 0)]
        .concat()
}

/// Returns the events of a guest since the last call.
pub fn heard(spacecraft: &mut Spacecraft, guest: GuestId) -> Vec<GuestEvent> {
    spacecraft.take_heard(guest).into_iter().map(|(_, event)| event).collect()
}

/// Returns the completed frames: bus, frame, sender.
pub fn completed(records: &[WireRecord]) -> Vec<(Bus, WireFrame, usize)> {
    let completed = |record: &WireRecord| match &record.record {
        Observation::Completed { trace, .. } => Some((record.bus, trace.frame, trace.transmitter)),
        _ => None,
    };
    records.iter().filter_map(completed).collect()
}

/// Requests a frame of four bytes from mailbox 0 and waits for its completion.
pub fn send(can: u32, id: u16, data: u32) -> Vec<u16> {
    [
        store(can + 0x184, 4),
        store(can + 0x188, data),
        store(can + 0x180, u32::from(id) << 21 | 1),
        wait_for(can + 8, 0),
        store(can + 8, 1),
    ]
    .concat()
}

/// Waits for a frame in FIFO 0, copies its low data word to `to` and releases it.
pub fn receive(can: u32, to: u32) -> Vec<u16> {
    // FMP counts in bits 0 and 1; the first frame sets bit 0.
    [wait_for(can + 0x0C, 0), copy(can + 0x1B8, to), store(can + 0x0C, 1 << 5)].concat()
}
