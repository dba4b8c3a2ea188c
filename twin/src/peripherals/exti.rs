//! EXTI and the part of SYSCFG that selects its pins.
//!
//! RM0090 chapters 9.2 and 12. Modelled: lines 0 to 15 from GPIO edges and software, 17 and 22 from the RTC, interrupts. Lines
//! 16 and 18 to 21 (PVD, USB, Ethernet, tamper) take software triggers only. Event mode (EMR) is stored without effect.

/// EXTI registers: IMR, EMR, RTSR, FTSR, SWIER, PR.
#[derive(Clone, Debug, Default)]
pub struct Exti {
    pub(super) words: [u32; 6],
}

const IMR: usize = 0;
const RTSR: usize = 2;
const FTSR: usize = 3;
const SWIER: usize = 4;
const PR: usize = 5;
const LINES: u32 = 0x7F_FFFF;

impl Exti {
    /// NVIC numbers of the lines (RM0090 table 61, RM0390 table 38). Line 19 is Ethernet, which the parts lack.
    const IRQS: [(u32, u16); 13] = [
        (1 << 0, 6),
        (1 << 1, 7),
        (1 << 2, 8),
        (1 << 3, 9),
        (1 << 4, 10),
        (0x1F << 5, 23),
        (0x3F << 10, 40),
        (1 << 16, 1),
        (1 << 17, 41),
        (1 << 18, 42),
        (1 << 20, 76),
        (1 << 21, 2),
        (1 << 22, 3),
    ];

    /// A load; `None` for what does not exist.
    pub fn read(&self, offset: u32) -> Option<u32> {
        self.words.get(offset as usize / 4).copied()
    }

    /// A store; `None` for what does not exist.
    pub fn write(&mut self, offset: u32, value: u32) -> Option<()> {
        let index = offset as usize / 4;
        let value = value & LINES;
        match index {
            PR => {
                self.words[PR] &= !value;
                self.words[SWIER] &= !value;
            }
            SWIER => {
                let risen = value & !self.words[SWIER];
                self.words[SWIER] |= value;
                self.words[PR] |= risen & self.words[IMR];
            }
            _ => *self.words.get_mut(index)? = value,
        }
        Some(())
    }

    /// Lines whose pin or other source went from `before` to `after`.
    pub fn edges(&mut self, before: u32, after: u32) {
        let rising = after & !before & self.words[RTSR];
        let falling = before & !after & self.words[FTSR];
        self.words[PR] |= (rising | falling) & self.words[IMR];
    }

    /// NVIC lines and their levels.
    pub fn irqs(&self) -> impl Iterator<Item = (u16, bool)> + use<> {
        let active = self.words[PR] & self.words[IMR];
        Self::IRQS.into_iter().map(move |(lines, irq)| (irq, active & lines != 0))
    }
}

/// SYSCFG: MEMRMP, PMC, EXTICR1..4, CMPCR.
#[derive(Clone, Debug, Default)]
pub struct Syscfg {
    pub(super) words: [u32; 9],
}

impl Syscfg {
    /// A load; `None` for what does not exist.
    pub fn read(&self, offset: u32) -> Option<u32> {
        match offset {
            0x00..=0x14 | 0x20 => Some(self.words[offset as usize / 4]),
            _ => None,
        }
    }

    /// A store; `None` for what does not exist or is not modelled: another memory at address zero.
    pub fn write(&mut self, offset: u32, value: u32) -> Option<()> {
        match offset {
            0x00 if value != 0 => None,
            0x00..=0x14 | 0x20 => {
                self.words[offset as usize / 4] = value;
                Some(())
            }
            _ => None,
        }
    }

    /// The port that feeds EXTI line `line`, A = 0.
    pub fn exti_port(&self, line: u32) -> usize {
        (self.words[2 + line as usize / 4] >> (4 * (line % 4)) & 0xF) as usize
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_selected_edge_raises_the_line_until_it_is_cleared() {
        let mut exti = Exti::default();
        exti.write(0x00, 1 << 7).unwrap();
        exti.write(0x0C, 1 << 7).unwrap();
        exti.edges(0, 1 << 7);
        assert!(exti.irqs().all(|(_, level)| !level), "rising is not selected");
        exti.edges(1 << 7, 0);
        assert_eq!(exti.irqs().find(|&(_, level)| level), Some((23, true)));
        exti.write(0x14, 1 << 7).unwrap();
        assert!(exti.irqs().all(|(_, level)| !level));
    }
}
