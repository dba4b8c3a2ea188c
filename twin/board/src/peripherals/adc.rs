//! ADC1 with the temperature sensor and the internal reference, one conversion at a time.
//!
//! RM0090 chapter 13. Modelled: regular conversions started by software, their time, resolution, EOC, STRT, overrun,
//! interrupts. Not modelled, and refused: sequences, continuous and injected conversions, external triggers, DMA, the
//! analog watchdog, left alignment, and a conversion of anything but sensor and reference. The supply is 3.3 V; a
//! sampling time that is too short for the sensor, and its 10 µs of start-up, cost no accuracy.

use crate::mmio::Refusal;
use crate::part::{Family, Part};

const SR: u32 = 0x00;
const CR1: u32 = 0x04;
const CR2: u32 = 0x08;
const SMPR1: u32 = 0x0C;
const SMPR2: u32 = 0x10;
const SQR1: u32 = 0x2C;
const SQR3: u32 = 0x34;
const DR: u32 = 0x4C;
const CSR: u32 = 0x300;
const CCR: u32 = 0x304;

const EOC: u32 = 1 << 1;
const STRT: u32 = 1 << 4;
const OVR: u32 = 1 << 5;
const EOCIE: u32 = 1 << 5;
const SCAN: u32 = 1 << 8;
const RES: u32 = 0b11 << 24;
const OVRIE: u32 = 1 << 26;
const ADON: u32 = 1 << 0;
const DDS: u32 = 1 << 9;
const EOCS: u32 = 1 << 10;
const EXTSEL: u32 = 0xF << 24;
const SWSTART: u32 = 1 << 30;
const ADCPRE: u32 = 0b11 << 16;
const VBATE: u32 = 1 << 22;
const TSVREFE: u32 = 1 << 23;

/// ADC1_IN of the sensor: 18 on later parts, shared with VBAT (RM0090 13.10, RM0390 13.10, RM0386, chapter "ADC").
const SENSOR_F405: u32 = 16;
const SENSOR_LATER: u32 = 18;
const REFERENCE: u32 = 17;
const SUPPLY_V: f64 = 3.3;
/// Typical values of DS8626 tables 69 and 72.
const REFERENCE_V: f64 = 1.21;
const SENSOR_AT_25_C_V: f64 = 0.76;
const SENSOR_V_PER_C: f64 = 0.0025;

/// ADC1 and the common registers.
#[derive(Clone, Debug)]
pub struct Adc {
    sr: u32,
    cr1: u32,
    cr2: u32,
    smpr: [u32; 2],
    sqr: [u32; 3],
    dr: u32,
    ccr: u32,
    /// The conversion under way: when it ends and with what.
    conversion: Option<(u64, u32)>,
    /// HCLK cycles per PCLK2 cycle.
    divider: u64,
    sensor: u32,
    temperature_c: f64,
}

impl Adc {
    /// After a reset.
    pub fn new(part: Part, temperature_c: f64) -> Self {
        let sensor = match part.family() {
            Family::F405 => SENSOR_F405,
            Family::F42x | Family::F446 | Family::F469 => SENSOR_LATER,
        };
        Adc::of(sensor, temperature_c)
    }

    fn of(sensor: u32, temperature_c: f64) -> Self {
        Adc {
            sensor,
            sr: 0,
            cr1: 0,
            cr2: 0,
            smpr: [0; 2],
            sqr: [0; 3],
            dr: 0,
            ccr: 0,
            conversion: None,
            divider: 1,
            temperature_c,
        }
    }

    /// RCC or a system reset; clock and temperature stay what they are.
    pub fn reset(&mut self) {
        *self = Adc { divider: self.divider, ..Adc::of(self.sensor, self.temperature_c) };
    }

    /// Junction temperature from now on, °C.
    pub fn set_temperature(&mut self, celsius: f64) {
        self.temperature_c = celsius;
    }

    /// The clock tree changed: `divider` HCLK cycles per PCLK2 cycle.
    pub fn set_divider(&mut self, divider: u64) {
        self.divider = divider;
    }

    fn catch_up(&mut self, cycle: u64) {
        let Some((_, value)) = self.conversion.take_if(|&mut (end, _)| end <= cycle) else { return };
        // With EOCS overruns are watched (RM0090 13.3.12 and 13.8.2): the unread value stays.
        if self.cr2 & EOCS != 0 && self.sr & EOC != 0 {
            self.sr |= OVR;
            return;
        }
        self.dr = value;
        self.sr |= EOC;
    }

    /// The interrupt line at `cycle`.
    pub fn irq(&mut self, cycle: u64) -> bool {
        self.catch_up(cycle);
        self.sr & EOC != 0 && self.cr1 & EOCIE != 0 || self.sr & OVR != 0 && self.cr1 & OVRIE != 0
    }

    /// The cycle at which the interrupt line may rise.
    pub fn next_event(&self) -> Option<u64> {
        let (end, _) = self.conversion?;
        (self.cr1 & (EOCIE | OVRIE) != 0).then_some(end)
    }

    /// A load.
    ///
    /// # Errors
    /// [`Refusal::Unmodelled`] for what does not exist or is not modelled.
    pub fn read(&mut self, cycle: u64, offset: u32) -> Result<u32, Refusal> {
        self.catch_up(cycle);
        Ok(match offset {
            SR => self.sr,
            CR1 => self.cr1,
            CR2 => self.cr2,
            SMPR1 | SMPR2 => self.smpr[(offset - SMPR1) as usize / 4],
            SQR1..=SQR3 => self.sqr[(offset - SQR1) as usize / 4],
            DR => {
                self.sr &= !EOC;
                self.dr
            }
            // The common status shows ADC1's in its lowest bits.
            CSR => self.sr,
            CCR => self.ccr,
            _ => return Err(Refusal::Unmodelled),
        })
    }

    /// A store.
    ///
    /// # Errors
    /// [`Refusal::Unmodelled`] for what does not exist or is not modelled.
    pub fn write(&mut self, cycle: u64, offset: u32, value: u32) -> Result<(), Refusal> {
        self.catch_up(cycle);
        let allowed = match offset {
            CR1 => EOCIE | SCAN | RES | OVRIE,
            CR2 => ADON | DDS | EOCS | EXTSEL | SWSTART,
            CCR => ADCPRE | VBATE | TSVREFE,
            _ => u32::MAX,
        };
        if value & !allowed != 0 {
            return Err(Refusal::Unmodelled);
        }
        match offset {
            // Flags clear by writing 0; writing 1 keeps them.
            SR => self.sr &= value,
            CR1 => self.cr1 = value,
            CR2 => return self.control(cycle, value),
            SMPR1 | SMPR2 => self.smpr[(offset - SMPR1) as usize / 4] = value,
            SQR1..=SQR3 => self.sqr[(offset - SQR1) as usize / 4] = value,
            DR | CSR => {}
            CCR => self.ccr = value,
            _ => return Err(Refusal::Unmodelled),
        }
        Ok(())
    }

    fn control(&mut self, cycle: u64, value: u32) -> Result<(), Refusal> {
        self.cr2 = value & !SWSTART;
        if value & ADON == 0 {
            self.conversion = None;
        } else if value & SWSTART != 0 && self.conversion.is_none() {
            self.conversion = Some(self.convert(cycle)?);
            self.sr |= STRT;
        }
        Ok(())
    }

    /// When a conversion that starts at `cycle` ends, and with what.
    fn convert(&self, cycle: u64) -> Result<(u64, u32), Refusal> {
        let length = self.sqr[0] >> 20 & 0xF;
        let channel = self.sqr[2] & 0x1F;
        let volts = match channel {
            _ if length != 0 => return Err(Refusal::Unmodelled),
            // VBAT takes precedence over the sensor on the channel that they share.
            SENSOR_LATER if self.ccr & VBATE != 0 => return Err(Refusal::Unmodelled),
            n if n == self.sensor => SENSOR_AT_25_C_V + (self.temperature_c - 25.0) * SENSOR_V_PER_C,
            REFERENCE => REFERENCE_V,
            _ => return Err(Refusal::Unmodelled),
        };
        // Both are off until TSVREFE wakes them.
        let volts = if self.ccr & TSVREFE != 0 { volts } else { 0.0 };
        let sampling =
            [3, 15, 28, 56, 84, 112, 144, 480][(self.smpr[0] >> (3 * (channel - 10)) & 0b111) as usize];
        let res = self.cr1 >> 24 & 0b11;
        let adc_cycles = sampling + 12 - 2 * u64::from(res);
        let adc_divider = 2 * (u64::from(self.ccr >> 16 & 0b11) + 1);
        Ok((cycle + adc_cycles * adc_divider * self.divider, code(volts) >> (2 * res)))
    }
}

/// The 12-bit code of a voltage.
fn code(volts: f64) -> u32 {
    (volts / SUPPLY_V * 4095.0).round().clamp(0.0, 4095.0) as u32
}

/// The words of factory calibration in system memory (DS8626 tables 70 and 73): VREFINT_CAL in the upper half at
/// 1FFF 7A28h; TS_CAL1 (30 °C) and TS_CAL2 (110 °C) at 1FFF 7A2Ch.
pub fn calibration() -> [u32; 2] {
    let sensor = |celsius: f64| code(SENSOR_AT_25_C_V + (celsius - 25.0) * SENSOR_V_PER_C);
    [0xFFFF | code(REFERENCE_V) << 16, sensor(30.0) | sensor(110.0) << 16]
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::part::tests::part;

    /// 168 MHz, PCLK2 at half of it, ADCPRE 4: 21 MHz, eight HCLK cycles per ADC cycle.
    fn powered(temperature_c: f64) -> Adc {
        let mut adc = Adc::new(part("STM32F405RG"), temperature_c);
        adc.set_divider(2);
        adc.write(0, CCR, TSVREFE | 1 << 16).unwrap();
        adc.write(0, CR2, ADON).unwrap();
        adc
    }

    fn start(adc: &mut Adc, channel: u32, sampling: u32) {
        adc.write(0, SQR3, channel).unwrap();
        adc.write(0, SMPR1, sampling << (3 * (channel - 10))).unwrap();
        adc.write(0, CR2, ADON | SWSTART).unwrap();
    }

    /// RM0090 13.7: sampling time plus 12 cycles.
    #[test]
    fn a_conversion_takes_its_sampling_time_and_twelve_cycles() {
        for (field, cycles) in [(0, 3 + 12), (4, 84 + 12), (7, 480 + 12)] {
            let mut adc = powered(25.0);
            start(&mut adc, SENSOR_F405, field);
            assert_eq!(adc.read(8 * cycles - 1, SR), Ok(STRT), "field {field}");
            assert_eq!(adc.read(8 * cycles, SR), Ok(STRT | EOC), "field {field}");
        }
    }

    #[test]
    fn a_lower_resolution_is_faster() {
        let mut adc = powered(25.0);
        // 8 bits: 3 + 8 cycles. 0.76 V / 3.3 V * 4095 = 943.1, its upper 8 bits 58.
        adc.write(0, CR1, 2 << 24).unwrap();
        start(&mut adc, SENSOR_F405, 0);
        assert_eq!(adc.read(8 * 11 - 1, SR).unwrap() & EOC, 0);
        assert_eq!(adc.read(8 * 11, DR), Ok(58));
    }

    #[test]
    fn reading_the_value_clears_eoc_and_nothing_else() {
        let mut adc = powered(25.0);
        start(&mut adc, REFERENCE, 0);
        // 1.21 V / 3.3 V * 4095 = 1501.5.
        assert!((1501..=1502).contains(&adc.read(1000, DR).unwrap()));
        assert_eq!(adc.read(1000, SR), Ok(STRT));
    }

    /// DS8626 6.3.22: 0.76 V at 25 °C, 2.5 mV/°C: 85 °C are 0.91 V, 1129.2 of 4095; -40 °C are 0.5975 V, 741.4.
    #[test]
    fn the_sensor_follows_the_temperature() {
        for (celsius, expected) in [(25.0, 943), (85.0, 1129), (-40.0, 741)] {
            let mut adc = powered(celsius);
            start(&mut adc, SENSOR_F405, 7);
            assert_eq!(adc.read(10_000, DR), Ok(expected), "{celsius} C");
        }
    }

    /// The formula of RM0090 13.10 on factory values gives the temperature back, to a code's 0.32 °C.
    #[test]
    fn the_calibration_words_fit_the_sensor() {
        let [_, word] = calibration();
        let (at_30, at_110) = (f64::from(word & 0xFFFF), f64::from(word >> 16));
        let mut adc = powered(63.0);
        start(&mut adc, SENSOR_F405, 7);
        let code = f64::from(adc.read(10_000, DR).unwrap());
        let celsius = (code - at_30) / (at_110 - at_30) * 80.0 + 30.0;
        assert!((celsius - 63.0).abs() < 0.5, "{celsius}");
    }

    #[test]
    fn the_f446_has_its_sensor_on_channel_18() {
        let mut adc = Adc::new(part("STM32F446RE"), 25.0);
        adc.write(0, CCR, TSVREFE).unwrap();
        adc.write(0, SQR3, 18).unwrap();
        adc.write(0, CR2, ADON | SWSTART).unwrap();
        assert_eq!(adc.read(1000, DR), Ok(943));
        adc.write(1000, CCR, TSVREFE | VBATE).unwrap();
        assert_eq!(adc.write(1000, CR2, ADON | SWSTART), Err(Refusal::Unmodelled));
    }

    #[test]
    fn without_tsvrefe_the_sensor_is_dead() {
        let mut adc = powered(25.0);
        adc.write(0, CCR, 1 << 16).unwrap();
        start(&mut adc, SENSOR_F405, 0);
        assert_eq!(adc.read(1000, DR), Ok(0));
    }

    #[test]
    fn the_end_of_conversion_interrupts() {
        let mut adc = powered(25.0);
        adc.write(0, CR1, EOCIE).unwrap();
        start(&mut adc, SENSOR_F405, 0);
        assert_eq!(adc.next_event(), Some(8 * 15));
        assert!(!adc.irq(8 * 15 - 1));
        assert!(adc.irq(8 * 15));
        adc.read(8 * 15, DR).unwrap();
        assert!(!adc.irq(8 * 15));
    }

    #[test]
    fn an_unread_value_overruns_with_eocs() {
        let mut adc = powered(25.0);
        adc.write(0, CR2, ADON | EOCS).unwrap();
        adc.write(0, SQR3, SENSOR_F405).unwrap();
        adc.write(0, CR2, ADON | EOCS | SWSTART).unwrap();
        adc.write(1000, CR2, ADON | EOCS | SWSTART).unwrap();
        assert_eq!(adc.read(2000, SR), Ok(STRT | EOC | OVR));
        adc.write(2000, SR, !(OVR | EOC)).unwrap();
        assert_eq!(adc.read(2000, SR), Ok(STRT));
    }

    #[test]
    fn nothing_starts_without_power() {
        let mut adc = powered(25.0);
        adc.write(0, CR2, SWSTART).unwrap();
        assert_eq!(adc.read(1000, SR), Ok(0));
    }

    #[test]
    fn what_is_not_modelled_is_refused() {
        let mut adc = powered(25.0);
        // CONT, DMA, ALIGN, JSWSTART, EXTEN; AWDEN in CR1.
        for bit in [1, 8, 11, 22, 28] {
            assert_eq!(adc.write(0, CR2, ADON | 1 << bit), Err(Refusal::Unmodelled), "bit {bit}");
        }
        assert_eq!(adc.write(0, CR1, 1 << 23), Err(Refusal::Unmodelled));
        adc.write(0, SQR3, 3).unwrap();
        assert_eq!(adc.write(0, CR2, ADON | SWSTART), Err(Refusal::Unmodelled));
    }
}
