@ Macros and names for all files of the image.
    .syntax unified
    .thumb
    .macro load reg, value          @ any constant or address
    movw \reg, #:lower16:(\value)
    movt \reg, #:upper16:(\value)
    .endm

    .macro case name                @ prints the lines of the case before, and begins with a core in a known state
    .pushsection .rodata
.Lcase\@: .asciz "\name"
    .popsection
    load r0, .Lcase\@
    bl begin_case
    .endm

    .macro note name, reg           @ adds a line with a name and a value; changes no register and no flag
    push {r0-r4, lr}
    mov r1, \reg
    mrs r4, apsr
    .pushsection .rodata
.Lname\@: .asciz "\name"
    .popsection
    load r0, .Lname\@
    bl add_line
    msr apsr_nzcvq, r4
    pop {r0-r4, lr}
    .endm

    .macro noted name, value        @ adds a line with a constant
    push {r5, lr}
    load r5, \value
    note "\name", r5
    pop {r5, lr}
    .endm

    .macro store address, value     @ stores a constant to a register of the system; uses r0 and r1
    load r0, \address
    load r1, \value
    str r1, [r0]
    .endm

    .macro peek reg, address        @ loads a word
    load \reg, \address
    ldr \reg, [\reg]
    .endm

    .macro show name, address       @ adds a line with a register of the system; uses r0
    peek r0, \address
    note "\name", r0
    .endm

    .macro handler exception, label @ sets a vector; uses r0 and r1
    store VECTORS + 4 * (\exception), \label
    .endm

    .macro resume label             @ the handler `record` returns there instead; uses r0 and r1
    store RESUME, \label
    .endm

    .macro pend mask                @ makes interrupts pending, by bits; uses r0 and r1
    store NVIC_ISPR, \mask
    dsb
    isb
    .endm

    .macro priority irq, value      @ sets the priority of an interrupt, in steps of 10h; uses r0 and r1
    load r0, NVIC_IPR + \irq
    movs r1, #\value
    strb r1, [r0]
    .endm

    .macro system_priority exception, value
    load r0, SHPR - 4 + \exception
    movs r1, #\value
    strb r1, [r0]
    .endm

    .equ SYST_CSR, 0xE000E010
    .equ SYST_RVR, 0xE000E014
    .equ SYST_CVR, 0xE000E018
    .equ NVIC_ISER, 0xE000E100
    .equ NVIC_ICER, 0xE000E180
    .equ NVIC_ISPR, 0xE000E200
    .equ NVIC_ICPR, 0xE000E280
    .equ NVIC_IABR, 0xE000E300
    .equ NVIC_IPR, 0xE000E400
    .equ CPUID, 0xE000ED00
    .equ ICSR, 0xE000ED04
    .equ VTOR, 0xE000ED08
    .equ AIRCR, 0xE000ED0C
    .equ CCR, 0xE000ED14
    .equ SHPR, 0xE000ED18
    .equ SHCSR, 0xE000ED24
    .equ CFSR, 0xE000ED28
    .equ HFSR, 0xE000ED2C
    .equ MMFAR, 0xE000ED34
    .equ BFAR, 0xE000ED38
    .equ CPACR, 0xE000ED88
    .equ MPU_TYPE, 0xE000ED90
    .equ MPU_CTRL, 0xE000ED94
    .equ MPU_RNR, 0xE000ED98
    .equ MPU_RBAR, 0xE000ED9C
    .equ MPU_RASR, 0xE000EDA0
    .equ STIR, 0xE000EF00
    .equ FPCCR, 0xE000EF34
    .equ FPCAR, 0xE000EF38
    .equ FPDSCR, 0xE000EF3C

    .equ PENDSVSET, 1 << 28
    .equ NMIPENDSET, 1 << 31
    .equ ALL_FAULTS, 7 << 16
    .equ STKALIGN, 1 << 9

    .equ NOWHERE, 0x60000000        @ no memory answers here
    .equ PERIPHERAL, 0x40000034     @ TIM2_CCR1: a word that keeps what is written
    .equ VECTORS, 0x20000000        @ vector table in RAM
    .equ RESUME, 0x20000200         @ where `record` returns, 0 for the place of the exception
    .equ LINES_END, 0x20000204      @ end of the lines that are not printed yet
    .equ CASE, 0x20000208           @ name of the case
    .equ ORIGIN, 0x2000020C         @ first instruction of the case
    .equ TEXT, 0x20000210           @ a line of text
    .equ LINES, 0x20000400          @ lines: name and value
    .equ DATA, 0x20001000           @ 4 KiB for the cases
    .equ RAM_END, 0x20030000
    .equ PROCESS_STACK, 0x20004000
    .equ MAIN_STACK, 0x20006000
    .equ CODE_IN_RAM, 0x20008000    @ 4 KiB for code that the cases write
