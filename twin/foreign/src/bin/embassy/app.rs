//! The requesting board and the answering board.

use defmt::{info, warn};
use embassy_executor::Spawner;
use embassy_futures::select::{Either, select};
use embassy_stm32::can::filter::Mask32;
use embassy_stm32::can::{
    Can, CanRx, CanTx, Fifo, Frame, Id, Rx0InterruptHandler, Rx1InterruptHandler, SceInterruptHandler,
    StandardId, TxInterruptHandler,
};
use embassy_stm32::gpio::{Input, Pull};
use embassy_stm32::peripherals::CAN1;
use embassy_stm32::rcc::{
    AHBPrescaler, APBPrescaler, Hse, HseMode, Pll, PllMul, PllPDiv, PllPreDiv, PllSource, Sysclk,
};
use embassy_stm32::time::Hertz;
use embassy_stm32::{Config, bind_interrupts};
use embassy_time::{Duration, Ticker, Timer};
use {defmt_rtt as _, panic_probe as _};

bind_interrupts!(struct Irqs {
    CAN1_TX => TxInterruptHandler<CAN1>;
    CAN1_RX0 => Rx0InterruptHandler<CAN1>;
    CAN1_RX1 => Rx1InterruptHandler<CAN1>;
    CAN1_SCE => SceInterruptHandler<CAN1>;
});

const QUESTION: u16 = 0x100;
const ANSWER: u16 = 0x200;
/// Period of the requests.
const PERIOD: Duration = Duration::from_millis(1);
/// Time after which a response counts as lost.
const PATIENCE: Duration = Duration::from_millis(5);

#[embassy_executor::main]
async fn main(_spawner: Spawner) {
    let p = embassy_stm32::init(config());
    let answers = Input::new(p.PA2, Pull::Up).is_low();
    let mut can = Can::new(p.CAN1, p.PB8, p.PB9, Irqs);
    can.modify_filters().clear().enable_bank(0, Fifo::Fifo0, Mask32::accept_all());
    can.modify_config().set_bitrate(1_000_000);
    can.enable().await;
    info!("on the bus");
    let (tx, rx) = can.split();
    if answers { answer(tx, rx).await } else { ask(tx, rx).await }
}

async fn ask(mut tx: CanTx<'static>, mut rx: CanRx<'static>) -> ! {
    let mut bus = Bus { works: true };
    let mut ticker = Ticker::every(PERIOD);
    for number in 0.. {
        ticker.next().await;
        tx.write(&frame(QUESTION, number)).await;
        // Responses to earlier requests may arrive late, after a bus-off.
        let answered = async { while listen(&mut rx, ANSWER, &mut bus).await != number {} };
        match select(answered, Timer::after(PATIENCE)).await {
            Either::First(()) => bus.worked(),
            Either::Second(()) => bus.failed(),
        }
    }
    defmt::unreachable!()
}

async fn answer(mut tx: CanTx<'static>, mut rx: CanRx<'static>) -> ! {
    let mut bus = Bus { works: true };
    loop {
        let number = listen(&mut rx, QUESTION, &mut bus).await;
        bus.worked();
        tx.write(&frame(ANSWER, number)).await;
    }
}

/// Returns the number in the next frame with this identifier.
async fn listen(rx: &mut CanRx<'static>, id: u16, bus: &mut Bus) -> u32 {
    loop {
        match rx.read().await {
            Ok(envelope) if *envelope.frame.id() == Id::Standard(standard(id)) => {
                if let Ok(bytes) = envelope.frame.data().try_into() {
                    return u32::from_le_bytes(bytes);
                }
            }
            Ok(_) => warn!("another frame"),
            Err(_) => bus.failed(),
        }
    }
}

/// Known state of the bus.
struct Bus {
    works: bool,
}

impl Bus {
    fn failed(&mut self) {
        if core::mem::replace(&mut self.works, false) {
            warn!("the bus fails");
        }
    }

    fn worked(&mut self) {
        if !core::mem::replace(&mut self.works, true) {
            info!("the bus works again");
        }
    }
}

fn standard(id: u16) -> StandardId {
    defmt::unwrap!(StandardId::new(id))
}

fn frame(id: u16, number: u32) -> Frame {
    defmt::unwrap!(Frame::new_data(standard(id), &number.to_le_bytes()).ok())
}

/// 168 MHz, APB1 at 42 MHz.
fn config() -> Config {
    let (hse, prediv) = if cfg!(feature = "nucleo-f446re") {
        (Hse { freq: Hertz(8_000_000), mode: HseMode::Bypass }, PllPreDiv::DIV4)
    } else {
        (Hse { freq: Hertz(12_000_000), mode: HseMode::Oscillator }, PllPreDiv::DIV6)
    };
    let mut config = Config::default();
    config.rcc.hse = Some(hse);
    config.rcc.pll_src = PllSource::HSE;
    config.rcc.pll =
        Some(Pll { prediv, mul: PllMul::MUL168, divp: Some(PllPDiv::DIV2), divq: None, divr: None });
    config.rcc.sys = Sysclk::PLL1_P;
    config.rcc.ahb_pre = AHBPrescaler::DIV1;
    config.rcc.apb1_pre = APBPrescaler::DIV4;
    config.rcc.apb2_pre = APBPrescaler::DIV2;
    config
}
