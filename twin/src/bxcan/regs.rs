//! Offsets and bits of the bxCAN registers, RM0090 32.9.
//!
//! Offsets count from the base of one controller; the filter registers exist behind CAN1 only.

/// Distance from CAN1 (4000 6400h) to CAN2 (4000 6800h), bytes.
pub const CONTROLLER_SIZE: u32 = 0x400;

pub const MCR: u32 = 0x000;
pub const MSR: u32 = 0x004;
pub const TSR: u32 = 0x008;
pub const RF0R: u32 = 0x00C;
pub const RF1R: u32 = 0x010;
pub const IER: u32 = 0x014;
pub const ESR: u32 = 0x018;
pub const BTR: u32 = 0x01C;
/// First transmit mailbox; three of 16 bytes each.
pub const TX_MAILBOXES: u32 = 0x180;
/// Output mailbox of FIFO 0; two of 16 bytes each.
pub const RX_MAILBOXES: u32 = 0x1B0;
pub const RX_MAILBOXES_END: u32 = 0x1D0;
pub const FMR: u32 = 0x200;
pub const FM1R: u32 = 0x204;
pub const FS1R: u32 = 0x20C;
pub const FFA1R: u32 = 0x214;
pub const FA1R: u32 = 0x21C;
/// First filter bank; 28 of two words each.
pub const BANKS: u32 = 0x240;
pub const BANKS_END: u32 = 0x320;

pub const MCR_INRQ: u32 = 1 << 0;
pub const MCR_SLEEP: u32 = 1 << 1;
pub const MCR_TXFP: u32 = 1 << 2;
pub const MCR_RFLM: u32 = 1 << 3;
pub const MCR_NART: u32 = 1 << 4;
pub const MCR_AWUM: u32 = 1 << 5;
pub const MCR_ABOM: u32 = 1 << 6;
pub const MCR_DBF: u32 = 1 << 16;
pub const MCR_RESET: u32 = 1 << 15;
/// INRQ, SLEEP, TXFP, RFLM, NART, AWUM, ABOM, TTCM and DBF; RESET never reads 1.
pub const MCR_STORED: u32 = 0x0001_00FF;
pub const MCR_AT_RESET: u32 = 0x0001_0002;

pub const MSR_INAK: u32 = 1 << 0;
pub const MSR_SLAK: u32 = 1 << 1;
pub const MSR_ERRI: u32 = 1 << 2;
pub const MSR_WKUI: u32 = 1 << 3;
pub const MSR_SLAKI: u32 = 1 << 4;
pub const MSR_TXM: u32 = 1 << 8;
pub const MSR_RXM: u32 = 1 << 9;
/// SAMP and RX: the line is recessive.
pub const MSR_RECESSIVE: u32 = 0b11 << 10;

pub const TSR_RQCP: u32 = 1 << 0;
pub const TSR_TXOK: u32 = 1 << 1;
pub const TSR_ALST: u32 = 1 << 2;
pub const TSR_TERR: u32 = 1 << 3;
pub const TSR_ABRQ: u32 = 1 << 7;

pub const RFR_FULL: u32 = 1 << 3;
pub const RFR_FOVR: u32 = 1 << 4;
pub const RFR_RFOM: u32 = 1 << 5;

pub const IER_TMEIE: u32 = 1 << 0;
/// Bits of FIFO 0; those of FIFO 1 are three higher.
pub const IER_FMPIE0: u32 = 1 << 1;
pub const IER_FFIE0: u32 = 1 << 2;
pub const IER_FOVIE0: u32 = 1 << 3;
pub const IER_EWGIE: u32 = 1 << 8;
pub const IER_EPVIE: u32 = 1 << 9;
pub const IER_BOFIE: u32 = 1 << 10;
pub const IER_LECIE: u32 = 1 << 11;
pub const IER_ERRIE: u32 = 1 << 15;
pub const IER_WKUIE: u32 = 1 << 16;
pub const IER_SLKIE: u32 = 1 << 17;
pub const IER_STORED: u32 = 0x0003_8F7F;

pub const ESR_EWGF: u32 = 1 << 0;
pub const ESR_EPVF: u32 = 1 << 1;
pub const ESR_BOFF: u32 = 1 << 2;
pub const ESR_LEC: u32 = 0b111 << 4;

pub const BTR_STORED: u32 = 0xC37F_03FF;
pub const BTR_AT_RESET: u32 = 0x0123_0000;
pub const BTR_LBKM: u32 = 1 << 30;
pub const BTR_SILM: u32 = 1 << 31;

pub const TIR_TXRQ: u32 = 1 << 0;
pub const TIR_RTR: u32 = 1 << 1;
pub const TIR_IDE: u32 = 1 << 2;
/// DLC, TGT and TIME.
pub const TDTR_STORED: u32 = 0xFFFF_010F;

pub const FMR_FINIT: u32 = 1 << 0;
pub const FMR_CAN2SB: u32 = 0x3F << 8;
pub const FMR_AT_RESET: u32 = 0x2A1C_0E01;
/// One bit per bank.
pub const BANK_BITS: u32 = 0x0FFF_FFFF;
