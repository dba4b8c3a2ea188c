//! The memory map of the parts, with reserved addresses.
//!
//! Names of memories, peripherals and registers are those of RM0090, RM0390 and RM0386 (tables 1, and the register map
//! at the end of each chapter). The manuals call all other addresses "reserved" and do not define accesses to them. The
//! twin is strict: they cause a bus fault, also in a gap behind a bridge to APB. Of the addresses of the core itself
//! (E000 0000h to E00F FFFFh) only DBGMCU is handled by this module.

use crate::model::FLASH_BASE;
use crate::part::{Lines, Part};

/// Names of registers, word by word; a dot is a gap.
const TIMER: &str =
    "CR1 CR2 SMCR DIER SR EGR CCMR1 CCMR2 CCER CNT PSC ARR RCR CCR1 CCR2 CCR3 CCR4 BDTR DCR DMAR OR";
const USART: &str = "SR DR BRR CR1 CR2 CR3 GTPR";
const SPI: &str = "CR1 CR2 SR DR CRCPR RXCRCR TXCRCR I2SCFGR I2SPR";
const I2C: &str = "CR1 CR2 OAR1 OAR2 DR SR1 SR2 CCR TRISE FLTR";
const CAN: &str = "MCR MSR TSR RF0R RF1R IER ESR BTR";
const DAC: &str =
    "CR SWTRIGR DHR12R1 DHR12L1 DHR8R1 DHR12R2 DHR12L2 DHR8R2 DHR12RD DHR12LD DHR8RD DOR1 DOR2 SR";
const ADC: &str =
    "SR CR1 CR2 SMPR1 SMPR2 JOFR1 JOFR2 JOFR3 JOFR4 HTR LTR SQR1 SQR2 SQR3 JSQR JDR1 JDR2 JDR3 JDR4 DR";
const GPIO: &str = "MODER OTYPER OSPEEDR PUPDR IDR ODR BSRR LCKR AFRL AFRH";
const RTC: &str = "TR DR CR ISR PRER WUTR CALIBR ALRMAR ALRMBR WPR SSR SHIFTR TSTR TSDR TSSSR CALR TAFCR ALRMASSR \
                   ALRMBSSR . BKP0R BKP1R BKP2R BKP3R BKP4R BKP5R BKP6R BKP7R BKP8R BKP9R BKP10R BKP11R BKP12R BKP13R \
                   BKP14R BKP15R BKP16R BKP17R BKP18R BKP19R";
const SDIO: &str =
    "POWER CLKCR ARG CMD RESPCMD RESP1 RESP2 RESP3 RESP4 DTIMER DLEN DCTRL DCOUNT STA ICR MASK . . FIFOCNT";
const RCC: &str = "CR PLLCFGR CFGR CIR AHB1RSTR AHB2RSTR AHB3RSTR . APB1RSTR APB2RSTR . . AHB1ENR AHB2ENR AHB3ENR . \
                   APB1ENR APB2ENR . . AHB1LPENR AHB2LPENR AHB3LPENR . APB1LPENR APB2LPENR . . BDCR CSR . . SSCGR \
                   PLLI2SCFGR PLLSAICFGR DCKCFGR CKGATENR DCKCFGR2";
const DMA: &str = "LISR HISR LIFCR HIFCR S0CR S0NDTR S0PAR S0M0AR S0M1AR S0FCR S1CR S1NDTR S1PAR S1M0AR S1M1AR S1FCR S2CR \
                   S2NDTR S2PAR S2M0AR S2M1AR S2FCR S3CR S3NDTR S3PAR S3M0AR S3M1AR S3FCR S4CR S4NDTR S4PAR S4M0AR \
                   S4M1AR S4FCR S5CR S5NDTR S5PAR S5M0AR S5M1AR S5FCR S6CR S6NDTR S6PAR S6M0AR S6M1AR S6FCR S7CR \
                   S7NDTR S7PAR S7M0AR S7M1AR S7FCR";
const FMPI2C: &str = "CR1 CR2 OAR1 OAR2 TIMINGR TIMEOUTR ISR ICR PECR RXDR TXDR";
const QUADSPI: &str = "CR DCR SR FCR DLR CCR AR ABR DR PSMKR PSMAR PIR LPTR";
const DCMI: &str = "CR SR RIS IER MIS ICR ESCR ESUR CWSTRT CWSIZE DR";
const LTDC: &str = ". . SSCR BPCR AWCR TWCR GCR . . SRCR . BCCR . IER ISR ICR LIPCR CPSR CDSR";
const DMA2D: &str = "CR ISR IFCR FGMAR FGOR BGMAR BGOR FGPFCCR FGCOLR BGPFCCR BGCOLR FGCMAR BGCMAR OPFCCR OCOLR OMAR OOR NLR LWR AMTCR";
const CRYP: &str = "CR SR DIN DOUT DMACR IMSCR RISR MISR";
/// The ports follow each other from A on.
const GPIO_BASE: u32 = 0x4002_0000;

/// A block: first address, length, name, registers, and the lines that have it.
type Place = (u32, u32, &'static str, &'static str, Lines);

const ALL: Lines = Lines::ALL;
const F405: Lines = Lines::F405;
const F446: Lines = Lines::F446;
const F429: Lines = Lines::F429;
const F439: Lines = Lines::F439;
const NOT_F446: Lines = ALL.without(F446);
/// All lines except the F405, 407, 415 and 417.
const LATER: Lines = ALL.without(Lines::F40X);
/// The F42x and F46x.
const TWO_BANKS: Lines = LATER.without(F446);
const WITH_ETHERNET: Lines = Lines::F407.and(Lines::F417).and(TWO_BANKS);
const WITH_CRYPTO: Lines = Lines::F415.and(Lines::F417).and(Lines::F437).and(F439).and(Lines::F479);

const PLACES: [Place; 80] = [
    (0x1FFF_0000, 0x7800, "system memory", "", ALL),
    (0x1FFF_7800, 0x210, "OTP area", "", ALL),
    // The unique ID, the size of the flash and the calibration of the ADC; the manuals do not define the area behind
    // them.
    (0x1FFF_7A10, 0x45F0, "device signature", "", ALL),
    (0x1FFF_C000, 0x10, "option bytes", "", ALL),
    (0x1FFE_C000, 0x10, "option bytes of the second bank", "", TWO_BANKS),
    (0x4000_0000, 0x400, "TIM2", TIMER, ALL),
    (0x4000_0400, 0x400, "TIM3", TIMER, ALL),
    (0x4000_0800, 0x400, "TIM4", TIMER, ALL),
    (0x4000_0C00, 0x400, "TIM5", TIMER, ALL),
    (0x4000_1000, 0x400, "TIM6", TIMER, ALL),
    (0x4000_1400, 0x400, "TIM7", TIMER, ALL),
    (0x4000_1800, 0x400, "TIM12", TIMER, ALL),
    (0x4000_1C00, 0x400, "TIM13", TIMER, ALL),
    (0x4000_2000, 0x400, "TIM14", TIMER, ALL),
    (0x4000_2800, 0x400, "RTC", RTC, ALL),
    (0x4000_2C00, 0x400, "WWDG", "CR CFR SR", ALL),
    (0x4000_3000, 0x400, "IWDG", "KR PR RLR SR", ALL),
    (0x4000_3400, 0x400, "I2S2ext", SPI, NOT_F446),
    (0x4000_3800, 0x400, "SPI2", SPI, ALL),
    (0x4000_3C00, 0x400, "SPI3", SPI, ALL),
    (0x4000_4000, 0x400, "I2S3ext", SPI, NOT_F446),
    (0x4000_4000, 0x400, "SPDIFRX", "CR IMR SR IFCR DR CSR DIR", F446),
    (0x4000_4400, 0x400, "USART2", USART, ALL),
    (0x4000_4800, 0x400, "USART3", USART, ALL),
    (0x4000_4C00, 0x400, "UART4", USART, ALL),
    (0x4000_5000, 0x400, "UART5", USART, ALL),
    (0x4000_5400, 0x400, "I2C1", I2C, ALL),
    (0x4000_5800, 0x400, "I2C2", I2C, ALL),
    (0x4000_5C00, 0x400, "I2C3", I2C, ALL),
    (0x4000_6000, 0x400, "FMPI2C1", FMPI2C, F446),
    (0x4000_6400, 0x400, "CAN1", CAN, ALL),
    (0x4000_6800, 0x400, "CAN2", CAN, ALL),
    (0x4000_6C00, 0x400, "CEC", "CR CFGR TXDR RXDR ISR IER", F446),
    (0x4000_7000, 0x400, "PWR", "CR CSR", ALL),
    (0x4000_7400, 0x400, "DAC", DAC, ALL),
    (0x4000_7800, 0x400, "UART7", USART, TWO_BANKS),
    (0x4000_7C00, 0x400, "UART8", USART, TWO_BANKS),
    (0x4001_0000, 0x400, "TIM1", TIMER, ALL),
    (0x4001_0400, 0x400, "TIM8", TIMER, ALL),
    (0x4001_1000, 0x400, "USART1", USART, ALL),
    (0x4001_1400, 0x400, "USART6", USART, ALL),
    (0x4001_2000, 0x100, "ADC1", ADC, ALL),
    (0x4001_2100, 0x100, "ADC2", ADC, ALL),
    (0x4001_2200, 0x100, "ADC3", ADC, ALL),
    (0x4001_2300, 0x100, "ADC", "CSR CCR CDR", ALL),
    (0x4001_2C00, 0x400, "SDIO", SDIO, ALL),
    (0x4001_3000, 0x400, "SPI1", SPI, ALL),
    (0x4001_3400, 0x400, "SPI4", SPI, LATER),
    (0x4001_3800, 0x400, "SYSCFG", "MEMRMP PMC EXTICR1 EXTICR2 EXTICR3 EXTICR4 . . CMPCR", ALL),
    (0x4001_3C00, 0x400, "EXTI", "IMR EMR RTSR FTSR SWIER PR", ALL),
    (0x4001_4000, 0x400, "TIM9", TIMER, ALL),
    (0x4001_4400, 0x400, "TIM10", TIMER, ALL),
    (0x4001_4800, 0x400, "TIM11", TIMER, ALL),
    (0x4001_5000, 0x400, "SPI5", SPI, TWO_BANKS),
    (0x4001_5400, 0x400, "SPI6", SPI, TWO_BANKS),
    (0x4001_5800, 0x400, "SAI1", "", LATER),
    (0x4001_5C00, 0x400, "SAI2", "", F446),
    (0x4001_6800, 0x400, "LTDC", LTDC, F429.and(F439).and(Lines::F46X)),
    (0x4001_6C00, 0x800, "DSI", "", Lines::F46X),
    (0x4002_3000, 0x400, "CRC", "DR IDR CR", ALL),
    (0x4002_3800, 0x400, "RCC", RCC, ALL),
    (0x4002_3C00, 0x400, "FLASH", "ACR KEYR OPTKEYR SR CR OPTCR", ALL),
    (0x4002_4000, 0x1000, "BKPSRAM", "", ALL),
    (0x4002_6000, 0x400, "DMA1", DMA, ALL),
    (0x4002_6400, 0x400, "DMA2", DMA, ALL),
    (0x4002_8000, 0x1400, "Ethernet MAC", "", WITH_ETHERNET),
    (0x4002_B000, 0xC00, "DMA2D", DMA2D, TWO_BANKS),
    (0x4004_0000, 0x4_0000, "USB OTG HS", "", ALL),
    (0x5000_0000, 0x4_0000, "USB OTG FS", "", ALL),
    (0x5005_0000, 0x400, "DCMI", DCMI, ALL.without(F405).without(Lines::F415)),
    (0x5006_0000, 0x400, "CRYP", CRYP, WITH_CRYPTO),
    (0x5006_0400, 0x400, "HASH", "CR DIN STR HR0 HR1 HR2 HR3 HR4 IMR SR", WITH_CRYPTO),
    (0x5006_0800, 0x400, "RNG", "CR SR DR", NOT_F446),
    (0x6000_0000, 0x2000_0000, "external memory", "", ALL),
    (0x8000_0000, 0x2000_0000, "external memory", "", ALL),
    (0xA000_0000, 0x1000, "FSMC", "", Lines::F40X),
    (0xA000_0000, 0x1000, "FMC", "", LATER),
    (0xA000_1000, 0x1000, "QUADSPI", QUADSPI, F446.and(Lines::F46X)),
    (0xC000_0000, 0x2000_0000, "external memory", "", LATER),
    (0xE004_2000, 0x400, "DBGMCU", "IDCODE CR APB1_FZ APB2_FZ", ALL),
];

/// Returns the register at `address`, as `DAC.SWTRIGR`, or `USB OTG FS + 800h` for a block whose registers are not in
/// the table. `None` for reserved addresses.
pub(crate) fn name(part: Part, address: u32) -> Option<String> {
    if let Some(port) = address.checked_sub(GPIO_BASE).map(|offset| offset / 0x400)
        && (port as usize) < part.ports()
    {
        let port = char::from(b'A' + port as u8);
        return Some(register(&format!("GPIO{port}"), GPIO, address % 0x400));
    }
    if let Some((base, name)) = memory(part, address) {
        return Some(register(name, "", address - base));
    }
    let &(base, _, name, registers, _) = place(part, address)?;
    if let Some(register) = can_register(name, address - base) {
        return Some(format!("{name}.{register}"));
    }
    Some(register(name, registers, address - base))
}

/// Returns the name of a mailbox or filter register of bxCAN (RM0090 table 174).
fn can_register(block: &str, offset: u32) -> Option<String> {
    if !block.starts_with("CAN") {
        return None;
    }
    let named = |names: [&str; 4], offset: u32| {
        names[offset as usize / 4 % 4].replace('#', &format!("{}", offset / 16))
    };
    match offset {
        0x180..0x1B0 => Some(named(["TI#R", "TDT#R", "TDL#R", "TDH#R"], offset - 0x180)),
        0x1B0..0x1D0 => Some(named(["RI#R", "RDT#R", "RDL#R", "RDH#R"], offset - 0x1B0)),
        0x200 if block == "CAN1" => Some("FMR".into()),
        0x204 if block == "CAN1" => Some("FM1R".into()),
        0x20C if block == "CAN1" => Some("FS1R".into()),
        0x214 if block == "CAN1" => Some("FFA1R".into()),
        0x21C if block == "CAN1" => Some("FA1R".into()),
        0x240..0x320 if block == "CAN1" => {
            let bank = (offset - 0x240) / 8;
            Some(format!("F{bank}R{}", offset / 4 % 2 + 1))
        }
        _ => None,
    }
}

/// Returns whether a part has nothing at `address`: the bus answers with a fault, which a program may survive.
pub(crate) fn is_reserved(part: Part, address: u32) -> bool {
    let is_port = (GPIO_BASE..GPIO_BASE + 0x400 * part.ports() as u32).contains(&address);
    !is_port && memory(part, address).is_none() && place(part, address).is_none()
}

/// First address and name of the memory at `address`.
fn memory(part: Part, address: u32) -> Option<(u32, &'static str)> {
    let memories = [
        (0x0000_0000, part.flash_bytes(), "flash at zero"),
        (FLASH_BASE, part.flash_bytes(), "flash"),
        (0x1000_0000, part.ccm_bytes(), "CCM"),
        (0x2000_0000, part.ram_bytes(), "SRAM"),
    ];
    let here = memories.into_iter().find(|&(base, bytes, _)| (base..base + bytes).contains(&address));
    here.map(|(base, _, name)| (base, name))
}

fn place(part: Part, address: u32) -> Option<&'static Place> {
    let is_here = |&&(base, len, _, _, lines): &&Place| {
        (base..=base + (len - 1)).contains(&address) && lines.has(part.lines())
    };
    PLACES.iter().find(is_here)
}

fn register(block: &str, registers: &str, offset: u32) -> String {
    match registers.split_whitespace().nth(offset as usize / 4).filter(|name| *name != ".") {
        Some(name) => format!("{block}.{name}"),
        None => format!("{block} + {offset:X}h"),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::part::tests::part;

    #[test]
    fn addresses_have_the_names_of_the_manual() {
        for (name_of_part, address, expected) in [
            ("STM32F405RG", 0x4000_7404, Some("DAC.SWTRIGR")),
            ("STM32F405RG", 0x4000_7406, Some("DAC.SWTRIGR")),
            ("STM32F405RG", 0x4000_7438, Some("DAC + 38h")),
            ("STM32F405RG", 0x4002_0C18, Some("GPIOD.BSRR")),
            ("STM32F405RG", 0x4002_2000, Some("GPIOI.MODER")),
            ("STM32F446RE", 0x4002_2000, None),
            ("STM32F405RG", 0x4002_3844, Some("RCC.APB2ENR")),
            ("STM32F405RG", 0x4002_3870, Some("RCC.BDCR")),
            ("STM32F446RE", 0x4002_3894, Some("RCC.DCKCFGR2")),
            ("STM32F405RG", 0x4002_3828, Some("RCC + 28h")),
            ("STM32F405RG", 0x4002_64B8, Some("DMA2.S7CR")),
            ("STM32F405RG", 0x4000_289C, Some("RTC.BKP19R")),
            ("STM32F405RG", 0x4001_0044, Some("TIM1.BDTR")),
            ("STM32F405RG", 0x4001_2308, Some("ADC.CDR")),
            ("STM32F405RG", 0x5000_0800, Some("USB OTG FS + 800h")),
            ("STM32F405RG", 0x5006_0804, Some("RNG.SR")),
            ("STM32F446RE", 0x5006_0804, None),
            ("STM32F446RE", 0xA000_1008, Some("QUADSPI.SR")),
            ("STM32F405RG", 0x4000_2400, None),
            ("STM32F407VG", 0x4002_9000, Some("Ethernet MAC + 1000h")),
            ("STM32F407VG", 0x5005_0028, Some("DCMI.DR")),
            ("STM32F415RG", 0x5006_0404, Some("HASH.DIN")),
            ("STM32F407VG", 0x5006_0404, None),
            ("STM32F427VI", 0x4000_7808, Some("UART7.BRR")),
            ("STM32F427VI", 0x4001_5008, Some("SPI5.SR")),
            ("STM32F429ZI", 0x4001_6818, Some("LTDC.GCR")),
            ("STM32F427ZI", 0x4001_6818, None),
            ("STM32F429NI", 0x4002_2814, Some("GPIOK.ODR")),
            ("STM32F429ZI", 0x4002_B004, Some("DMA2D.ISR")),
            ("STM32F439ZI", 0x1FFE_C000, Some("option bytes of the second bank + 0h")),
            ("STM32F429ZI", 0x2002_FFFC, Some("SRAM + 2FFFCh")),
            ("STM32F469NI", 0x4001_6C00, Some("DSI + 0h")),
            ("STM32F469NI", 0x2004_FFFC, Some("SRAM + 4FFFCh")),
            ("STM32F479NI", 0x5006_0000, Some("CRYP.CR")),
            ("STM32F469NI", 0xA000_1000, Some("QUADSPI.CR")),
        ] {
            let of = part(name_of_part);
            assert_eq!(name(of, address).as_deref(), expected, "{name_of_part}: {address:08X}h");
        }
    }

    /// First and last addresses of the gaps that all parts have, by the figures "Memory map" of the data sheets
    /// (DS8626, DS9405, DS10693, DS11189) and tables 1 of RM0090, RM0390 and RM0386.
    const GAPS_OF_ALL: [(u32, u32); 10] = [
        (0x1FFF_C010, 0x1FFF_FFFF),
        (0x4000_2400, 0x4000_27FF),
        (0x4001_0800, 0x4001_0FFF),
        (0x4001_1800, 0x4001_1FFF),
        (0x4001_2400, 0x4001_2BFF),
        (0x4001_4C00, 0x4001_4FFF),
        (0x4002_3400, 0x4002_37FF),
        (0x4002_5000, 0x4002_5FFF),
        (0x4008_0000, 0x4FFF_FFFF),
        (0x5004_0000, 0x5004_FFFF),
    ];
    const GAPS_OF_THE_F405: [(u32, u32); 16] = [
        (0x0010_0000, 0x07FF_FFFF),
        (0x0810_0000, 0x0FFF_FFFF),
        (0x1001_0000, 0x1FFE_FFFF),
        (0x2002_0000, 0x3FFF_FFFF),
        (0x4000_6000, 0x4000_63FF),
        (0x4000_6C00, 0x4000_6FFF),
        (0x4000_7800, 0x4000_FFFF),
        (0x4001_3400, 0x4001_37FF),
        (0x4001_5000, 0x4001_57FF),
        (0x4001_5800, 0x4001_FFFF),
        (0x4002_2400, 0x4002_2FFF),
        (0x4002_6800, 0x4003_FFFF),
        (0x5005_0000, 0x5006_07FF),
        (0x5006_0C00, 0x5FFF_FFFF),
        (0xA000_1000, 0xDFFF_FFFF),
        (0xE010_0000, 0xFFFF_FFFF),
    ];
    const GAPS_OF_THE_F417: [(u32, u32); 4] = [
        (0x4002_6800, 0x4002_7FFF),
        (0x4002_9400, 0x4003_FFFF),
        (0x5005_0400, 0x5005_FFFF),
        (0x5006_0C00, 0x5FFF_FFFF),
    ];
    const GAPS_OF_THE_F427: [(u32, u32); 18] = [
        (0x0020_0000, 0x07FF_FFFF),
        (0x0820_0000, 0x0FFF_FFFF),
        (0x1001_0000, 0x1FFE_BFFF),
        (0x1FFE_C010, 0x1FFE_FFFF),
        (0x2003_0000, 0x3FFF_FFFF),
        (0x4000_6000, 0x4000_63FF),
        (0x4000_6C00, 0x4000_6FFF),
        (0x4000_8000, 0x4000_FFFF),
        (0x4001_5C00, 0x4001_67FF),
        (0x4001_6800, 0x4001_FFFF),
        (0x4002_2C00, 0x4002_2FFF),
        (0x4002_6800, 0x4002_7FFF),
        (0x4002_9400, 0x4002_AFFF),
        (0x4002_BC00, 0x4003_FFFF),
        (0x5005_0400, 0x5006_07FF),
        (0x5006_0C00, 0x5FFF_FFFF),
        (0xA000_1000, 0xBFFF_FFFF),
        (0xE010_0000, 0xFFFF_FFFF),
    ];
    const GAPS_OF_THE_F446: [(u32, u32); 11] = [
        (0x0008_0000, 0x07FF_FFFF),
        (0x0808_0000, 0x1FFE_FFFF),
        (0x2002_0000, 0x3FFF_FFFF),
        (0x4000_3400, 0x4000_37FF),
        (0x4000_7800, 0x4000_FFFF),
        (0x4001_5000, 0x4001_57FF),
        (0x4001_6000, 0x4001_FFFF),
        (0x4002_2000, 0x4002_2FFF),
        (0x4002_6800, 0x4003_FFFF),
        (0x5005_0400, 0x5FFF_FFFF),
        (0xA000_2000, 0xBFFF_FFFF),
    ];
    const GAPS_OF_THE_F469: [(u32, u32); 4] = [
        (0x2005_0000, 0x3FFF_FFFF),
        (0x4001_5C00, 0x4001_67FF),
        (0x4001_7400, 0x4001_FFFF),
        (0xA000_2000, 0xBFFF_FFFF),
    ];

    /// First address of the registers of the core.
    const CORE: u32 = 0xE000_0000;

    /// Returns whether all addresses from `first` to `last` are reserved, checked in steps of the smallest block.
    fn is_empty(part: Part, first: u32, last: u32) -> bool {
        let steps = (first..=last).step_by(((last - first) / 0x1000).max(0x10) as usize & !0xF);
        steps.chain([last]).all(|address| is_reserved(part, address) || address >> 20 == CORE >> 20)
    }

    /// Given each gap of the memory map, then all of it is reserved, and the addresses before and behind it are not
    /// reserved, or are another gap.
    #[test]
    fn gaps_of_the_memory_map_are_reserved_to_their_ends() {
        for (name, own) in [
            ("STM32F405RG", &GAPS_OF_THE_F405[..]),
            ("STM32F417VG", &GAPS_OF_THE_F417),
            ("STM32F427VI", &GAPS_OF_THE_F427),
            ("STM32F446RE", &GAPS_OF_THE_F446),
            ("STM32F469NI", &GAPS_OF_THE_F469),
        ] {
            let gaps: Vec<_> = GAPS_OF_ALL.iter().chain(own).collect();
            let is_gap = |address: u32| gaps.iter().any(|&&(first, last)| (first..=last).contains(&address));
            for &&(first, last) in &gaps {
                assert!(is_empty(part(name), first, last), "{name}: {first:08X}h to {last:08X}h");
            }
            for &(first, last) in own {
                for address in [first.wrapping_sub(1), last.wrapping_add(1)] {
                    if address >> 20 != CORE >> 20 {
                        assert_eq!(
                            is_reserved(part(name), address),
                            is_gap(address),
                            "{name}: {address:08X}h"
                        );
                    }
                }
            }
        }
    }
}
