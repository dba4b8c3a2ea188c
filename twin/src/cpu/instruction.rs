//! Decoded instructions, which the decoder produces and the executor consumes.
//!
//! A decoded instruction holds register numbers and constants, ready for use. It does not hold its own address or size. Sections in
//! the comments are those of DDI 0403.

use crate::cpu::bus::Width;

/// Number of a core register, 0 to 15.
pub type Reg = u8;

/// Operation on two operands. The last four change flags alone.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Alu {
    And,
    Bic,
    Orr,
    Orn,
    Eor,
    Mov,
    Mvn,
    Add,
    Adc,
    Sbc,
    Sub,
    Rsb,
    Tst,
    Teq,
    Cmn,
    Cmp,
}

/// Kind of a shift (A7.4).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ShiftKind {
    Lsl,
    Lsr,
    Asr,
    Ror,
    Rrx,
}

/// A shift by a constant: 0 to 31 for LSL, 1 to 32 for LSR and ASR, 1 to 31 for ROR.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Shift {
    pub kind: ShiftKind,
    pub amount: u8,
}

impl Shift {
    pub const NONE: Shift = Shift { kind: ShiftKind::Lsl, amount: 0 };
}

/// Condition code of a conditional instruction, 0 (EQ) to 14 (AL) (A7.3).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Condition(pub u8);

/// Size and sign of a single load or store.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Size {
    Byte,
    SignedByte,
    Half,
    SignedHalf,
    Word,
}

impl Size {
    pub fn width(self) -> Width {
        match self {
            Size::Byte | Size::SignedByte => Width::Byte,
            Size::Half | Size::SignedHalf => Width::Half,
            Size::Word => Width::Word,
        }
    }
}

/// Use of the base register by a load or store.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Index {
    /// Base plus offset; the base stays.
    Offset,
    /// Base plus offset, which is written to the base.
    Pre,
    /// Base; base plus offset is written to the base afterwards.
    Post,
    /// As `Offset`, with the rights of unprivileged code.
    Unprivileged,
}

impl Index {
    #[inline]
    pub fn writes_base(self) -> bool {
        matches!(self, Index::Pre | Index::Post)
    }
}

/// The address of a load or store by a base register and a constant.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Indexed {
    pub index: Index,
    pub rn: Reg,
    pub offset: i16,
}

/// Registers that a load or store multiple transfers, and its base register.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Block {
    pub rn: Reg,
    pub list: u16,
    pub decrement: bool,
    pub writeback: bool,
}

/// Part of a register that an extension takes (A7.7, SXTAB to SXTH and UXTAB to UXTH).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Extension {
    SignedByte,
    SignedHalf,
    SignedBytes16,
    Byte,
    Half,
    Bytes16,
}

/// Reordering or counting of the bits of one register.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Reverse {
    Bytes,
    BytesOfHalves,
    SignedHalf,
    Bits,
    CountLeadingZeros,
}

/// Lanes of a parallel addition or subtraction (A4.4.5).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Lanes {
    Add16,
    /// Exchange halves, add high, subtract low.
    Asx,
    /// Exchange halves, subtract high, add low.
    Sax,
    Sub16,
    Add8,
    Sub8,
}

/// Treatment of the result of each lane.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Treatment {
    /// Modulo; sets GE.
    Plain,
    Saturating,
    Halving,
}

/// Saturating addition and subtraction of words.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Saturating {
    Add,
    DoubleAdd,
    Sub,
    DoubleSub,
}

/// Multiplication with a 64-bit result.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum LongMultiply {
    Unsigned,
    Signed,
    UnsignedAccumulate,
    SignedAccumulate,
    UnsignedAccumulateBoth,
}

/// Hint; those without an effect are `Nop`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Hint {
    Nop,
    WaitForEvent,
    WaitForInterrupt,
    SendEvent,
}

/// FP operation on two operands.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum FpBinary {
    Add,
    Sub,
    Mul,
    NegMul,
    Div,
}

/// FP operation on one operand.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum FpUnary {
    Mov,
    Abs,
    Neg,
    Sqrt,
}

/// FP conversion (A7.7, VCVT).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum FpConvert {
    /// Integer to float.
    FromInteger { signed: bool },
    /// Float to integer; rounds towards zero or as FPSCR says.
    ToInteger { signed: bool, to_zero: bool },
    /// Fixed point to float; the source is a half-word or word.
    FromFixed { signed: bool, word: bool, fraction: u8 },
    /// Float to fixed point, towards zero.
    ToFixed { signed: bool, word: bool, fraction: u8 },
    /// Half precision to single; the half-word of the source.
    FromHalf { top: bool },
    /// Single to half precision; the half-word of the destination.
    ToHalf { top: bool },
}

/// One decoded instruction.
#[rustfmt::skip] // One line for each instruction.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Instruction {
    /// No such instruction: UsageFault with UNDEFINSTR.
    Undefined,
    /// The manual calls the encoding UNPREDICTABLE.
    Unpredictable,
    /// An instruction of a coprocessor that is not there: UsageFault with NOCP.
    NoCoprocessor,

    /// `rotated`: the constant sets the carry of logical operations to its bit 31.
    AluImmediate { op: Alu, s: bool, rotated: bool, rd: Reg, rn: Reg, imm: u32 },
    AluRegister { op: Alu, s: bool, rd: Reg, rn: Reg, rm: Reg, shift: Shift },
    /// Shift by the low byte of a register.
    ShiftRegister { kind: ShiftKind, s: bool, rd: Reg, rn: Reg, rm: Reg },
    /// ADD or MOV to PC: a branch (A7.7.4, A7.7.77).
    MovPc { rm: Reg },
    AddPc { rm: Reg },
    /// Aligned PC plus offset (A7.7.7).
    Adr { rd: Reg, offset: i16 },
    MovTop { rd: Reg, imm: u16 },
    BitFieldInsert { rd: Reg, rn: Reg, lsb: u8, width: u8 },
    BitFieldClear { rd: Reg, lsb: u8, width: u8 },
    BitFieldExtract { signed: bool, rd: Reg, rn: Reg, lsb: u8, width: u8 },
    Saturate { signed: bool, bits: u8, rd: Reg, rn: Reg, shift: Shift },
    Saturate16 { signed: bool, bits: u8, rd: Reg, rn: Reg },
    /// `rn` 15: nothing is added.
    Extend { kind: Extension, rd: Reg, rn: Reg, rm: Reg, rotation: u8 },
    Reverse { kind: Reverse, rd: Reg, rm: Reg },

    Parallel { lanes: Lanes, treatment: Treatment, signed: bool, rd: Reg, rn: Reg, rm: Reg },
    SaturatingAdd { op: Saturating, rd: Reg, rn: Reg, rm: Reg },
    Select { rd: Reg, rn: Reg, rm: Reg },
    /// PKHBT, or PKHTB with `top`.
    Pack { top: bool, rd: Reg, rn: Reg, rm: Reg, shift: Shift },
    /// `ra` 15: nothing is added.
    AbsoluteDifferences { rd: Reg, rn: Reg, rm: Reg, ra: Reg },

    Multiply { s: bool, rd: Reg, rn: Reg, rm: Reg },
    MultiplyAccumulate { subtract: bool, rd: Reg, rn: Reg, rm: Reg, ra: Reg },
    MultiplyLong { op: LongMultiply, low: Reg, high: Reg, rn: Reg, rm: Reg },
    Divide { signed: bool, rd: Reg, rn: Reg, rm: Reg },
    /// SMULxy, SMLAxy; `ra` 15: nothing is added.
    MultiplyHalves { rd: Reg, rn: Reg, rm: Reg, ra: Reg, n_top: bool, m_top: bool },
    /// SMULWy, SMLAWy.
    MultiplyWordHalf { rd: Reg, rn: Reg, rm: Reg, ra: Reg, m_top: bool },
    /// SMUAD, SMUSD, SMLAD, SMLSD.
    MultiplyDual { subtract: bool, exchange: bool, rd: Reg, rn: Reg, rm: Reg, ra: Reg },
    /// SMMUL, SMMLA, SMMLS.
    MultiplyHigh { subtract: bool, round: bool, rd: Reg, rn: Reg, rm: Reg, ra: Reg },
    /// SMLALxy.
    MultiplyHalvesLong { low: Reg, high: Reg, rn: Reg, rm: Reg, n_top: bool, m_top: bool },
    /// SMLALD, SMLSLD.
    MultiplyDualLong { subtract: bool, exchange: bool, low: Reg, high: Reg, rn: Reg, rm: Reg },

    Load { size: Size, rt: Reg, at: Indexed },
    LoadRegister { size: Size, rt: Reg, rn: Reg, rm: Reg, shift: u8 },
    LoadLiteral { size: Size, rt: Reg, offset: i16 },
    Store { size: Size, rt: Reg, at: Indexed },
    StoreRegister { size: Size, rt: Reg, rn: Reg, rm: Reg, shift: u8 },
    /// LDRD, STRD. `rn` 15: a literal.
    Dual { load: bool, rt: Reg, rt2: Reg, at: Indexed },
    /// LDM, STM.
    Multiple { load: bool, block: Block },
    LoadExclusive { size: Size, rt: Reg, rn: Reg, offset: u16 },
    StoreExclusive { size: Size, rd: Reg, rt: Reg, rn: Reg, offset: u16 },
    ClearExclusive,

    Branch { offset: i32 },
    BranchIf { condition: Condition, offset: i32 },
    BranchLink { offset: i32 },
    BranchExchange { rm: Reg },
    BranchLinkExchange { rm: Reg },
    CompareBranch { rn: Reg, non_zero: bool, offset: u8 },
    TableBranch { half: bool, rn: Reg, rm: Reg },

    /// ITSTATE that the instruction sets.
    IfThen { state: u8 },
    Hint { hint: Hint },
    /// DMB, DSB, ISB.
    Barrier,
    ChangeState { disable: bool, primask: bool, faultmask: bool },
    MoveFromSpecial { rd: Reg, register: u8 },
    MoveToSpecial { rn: Reg, register: u8, mask: u8 },
    SupervisorCall,
    Breakpoint { immediate: u8 },

    /// An encoding in the space of the FPU that it does not have: NOCP while the FPU is off, then UNDEFINSTR.
    FpUndefined,
    FpBinary { op: FpBinary, d: Reg, n: Reg, m: Reg },
    /// VMLA, VMLS, VNMLA, VNMLS, which round the product as well; with `fused` VFMA, VFMS, VFNMA, VFNMS, which round once.
    FpAccumulate { fused: bool, negate_addend: bool, negate_product: bool, d: Reg, n: Reg, m: Reg },
    FpUnary { op: FpUnary, d: Reg, m: Reg },
    FpImmediate { d: Reg, value: u32 },
    /// `zero`: compares with +0. `quiet_raises`: VCMPE.
    FpCompare { quiet_raises: bool, zero: bool, d: Reg, m: Reg },
    FpConvert { op: FpConvert, d: Reg, m: Reg },
    /// VMOV between a core register and a single register.
    FpMoveCore { to_core: bool, rt: Reg, n: Reg },
    /// VMOV between two core registers and two consecutive single registers.
    FpMovePair { to_core: bool, rt: Reg, rt2: Reg, m: Reg },
    /// VMRS; `rt` 15: the flags go to APSR.
    FpStatusRead { rt: Reg },
    FpStatusWrite { rt: Reg },
    /// VLDR, VSTR of `count` words.
    FpTransfer { load: bool, d: Reg, count: u8, rn: Reg, offset: i16 },
    /// VLDM, VSTM.
    FpMultiple { load: bool, d: Reg, count: u8, rn: Reg, decrement: bool, writeback: bool },
}

/// Places of an instruction in an IT block.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum InBlock {
    Anywhere,
    /// Only at its end, because it branches.
    Last,
    Never,
}

impl Instruction {
    /// Returns the places that the instruction may have in an IT block (A7.7.38 and the entry of each instruction).
    pub fn in_block(self, narrow: bool) -> InBlock {
        use Instruction::{
            AddPc, AluRegister, Branch, BranchExchange, BranchIf, BranchLink, BranchLinkExchange,
            ChangeState, CompareBranch, IfThen, Load, LoadLiteral, LoadRegister, MovPc, Multiple,
            TableBranch,
        };
        match self {
            BranchIf { .. } | CompareBranch { .. } | IfThen { .. } | ChangeState { .. } => InBlock::Never,
            // MOVS of two low registers, encoding T2.
            AluRegister { op: Alu::Mov, s: true, shift: Shift::NONE, .. } if narrow => InBlock::Never,
            Branch { .. }
            | BranchLink { .. }
            | BranchExchange { .. }
            | BranchLinkExchange { .. }
            | TableBranch { .. }
            | MovPc { .. }
            | AddPc { .. }
            | Load { rt: 15, .. }
            | LoadRegister { rt: 15, .. }
            | LoadLiteral { rt: 15, .. } => InBlock::Last,
            Multiple { load: true, block } if block.list & 1 << 15 != 0 => InBlock::Last,
            _ => InBlock::Anywhere,
        }
    }

    /// Returns the same instruction without effect on the flags, as the 16-bit encodings of data processing are in an
    /// IT block.
    pub fn without_flags(mut self) -> Self {
        match &mut self {
            Instruction::AluImmediate { s, .. }
            | Instruction::AluRegister { s, .. }
            | Instruction::ShiftRegister { s, .. }
            | Instruction::Multiply { s, .. } => *s = false,
            _ => {}
        }
        self
    }
}

/// A decoded instruction and its size.
#[derive(Clone, Copy, Debug)]
#[repr(align(16))]
pub struct Decoded {
    pub instruction: Instruction,
    /// Bytes: 2 or 4; 0 if nothing is known of an address.
    pub size: u8,
}
