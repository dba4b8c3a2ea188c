//! Numbers of exceptions, causes that end an instruction early, and kinds of sleep (B1.5).

pub const NMI: u16 = 2;
pub const HARD_FAULT: u16 = 3;
pub const MEM_MANAGE: u16 = 4;
pub const BUS_FAULT: u16 = 5;
pub const USAGE_FAULT: u16 = 6;
pub const SV_CALL: u16 = 11;
pub const DEBUG_MONITOR: u16 = 12;
pub const PEND_SV: u16 = 14;
pub const SYSTICK: u16 = 15;
/// Number of interrupt 0.
pub const INTERRUPTS: u16 = 16;

/// Bits of CFSR (B3.2.15).
pub const IACCVIOL: u32 = 1;
pub const DACCVIOL: u32 = 1 << 1;
pub const MUNSTKERR: u32 = 1 << 3;
pub const MSTKERR: u32 = 1 << 4;
pub const MLSPERR: u32 = 1 << 5;
pub const MMARVALID: u32 = 1 << 7;
pub const IBUSERR: u32 = 1 << 8;
pub const PRECISERR: u32 = 1 << 9;
pub const UNSTKERR: u32 = 1 << 11;
pub const STKERR: u32 = 1 << 12;
pub const LSPERR: u32 = 1 << 13;
pub const BFARVALID: u32 = 1 << 15;
pub const UNDEFINSTR: u32 = 1 << 16;
pub const INVSTATE: u32 = 1 << 17;
pub const INVPC: u32 = 1 << 18;
pub const NOCP: u32 = 1 << 19;
pub const UNALIGNED: u32 = 1 << 24;
pub const DIVBYZERO: u32 = 1 << 25;

/// Cause that ends an instruction before its end.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Trap {
    /// UsageFault with these bits of CFSR.
    Usage(u32),
    /// The bus refused a fetch.
    FetchBus,
    /// Execute-never, or the MPU refused a fetch.
    FetchAccess,
    /// The bus refused a load or store at this address.
    DataBus(u32),
    /// The MPU refused a load or store at this address.
    DataAccess(u32),
    /// A store of FPU registers that entry had left out raised this exception. `None`: the core locks up.
    Deferred(Option<u16>),
    /// SVC. The instruction is complete.
    SupervisorCall,
    /// SVC at a priority that its exception cannot preempt.
    RefusedCall,
    /// BKPT with its constant.
    Breakpoint(u8),
    Unpredictable,
    /// The instruction, a store to AIRCR, is complete.
    ResetRequest,
    /// A system register that is not modelled.
    Unmodelled {
        address: u32,
        write: bool,
    },
}

impl Trap {
    pub const UNDEFINED: Trap = Trap::Usage(UNDEFINSTR);
    pub const INVALID_STATE: Trap = Trap::Usage(INVSTATE);
    pub const NO_COPROCESSOR: Trap = Trap::Usage(NOCP);
    pub const UNALIGNED: Trap = Trap::Usage(UNALIGNED);
    pub const DIVIDE_BY_ZERO: Trap = Trap::Usage(DIVBYZERO);
}

/// Kind of sleep (B1.5.17, B1.5.18).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Sleep {
    Awake,
    /// WFE.
    ForEvent,
    /// WFI, or SLEEPONEXIT.
    ForInterrupt,
}
