@ SysTick with both clocks: order of events, no exact counts.
    .include "macros.s"
    .text
    .equ ENABLE, 1
    .equ TICKINT, 2
    .equ CORE_CLOCK, 4
    .equ COUNTFLAG, 1 << 16

    .macro start reload, control
    store SYST_CSR, 0
    store SYST_RVR, \reload
    store SYST_CVR, 0
    store SYST_CSR, \control
    .endm

    .macro await_flag                   @ polls COUNTFLAG, which the poll clears
9:  peek r4, SYST_CSR
    lsls r5, r4, #15
    bpl 9b
    note "csr", r4
    .endm

    .thumb_func
    .global systick_cases
systick_cases:
    push {r3-r7, lr}

    case "systick_registers"
    store SYST_CSR, 0
    store SYST_RVR, 0xFFFFFFFF
    store SYST_CVR, 0x1234
    show "csr", SYST_CSR
    show "rvr", SYST_RVR
    show "cvr", SYST_CVR

    case "flag_with_core_clock"
    start 99, ENABLE + CORE_CLOCK
    await_flag
    show "again", SYST_CSR
    await_flag

    case "flag_with_reference_clock"
    start 99, ENABLE
    await_flag
    show "again", SYST_CSR
    await_flag

    case "value_is_below_reload"
    start 999, ENABLE + CORE_CLOCK
    await_flag
    peek r4, SYST_CVR
    movs r6, #1
    cmp r4, #1000
    it hs
    movhs r6, #0
    note "below", r6

    case "counts_down"
    start 0x00FFFFFF, ENABLE + CORE_CLOCK
    bl wait
    peek r4, SYST_CVR
    bl wait
    peek r5, SYST_CVR
    bl is_below
    store SYST_CSR, CORE_CLOCK          @ stands still
    peek r5, SYST_CVR
    bl wait
    peek r4, SYST_CVR
    subs r6, r5, r4
    note "difference", r6

    case "reference_clock_is_slower"
    start 0x00FFFFFF, ENABLE
    bl wait
    peek r4, SYST_CVR
    bl wait
    peek r7, SYST_CVR
    subs r7, r4, r7
    start 0x00FFFFFF, ENABLE + CORE_CLOCK
    bl wait
    peek r4, SYST_CVR
    bl wait
    peek r5, SYST_CVR
    subs r4, r5
    mov r5, r7
    bl is_below

    case "write_clears_value_and_flag"
    start 99, ENABLE + CORE_CLOCK
    bl wait
    store SYST_CSR, CORE_CLOCK
    store SYST_CVR, 55
    show "cvr", SYST_CVR
    show "csr", SYST_CSR

    case "systick_interrupt"
    handler 15, once
    start 200, ENABLE + TICKINT + CORE_CLOCK
    bl wait
    show "csr", SYST_CSR

    case "systick_interrupt_of_reference_clock"
    handler 15, once
    start 20, ENABLE + TICKINT
    bl wait
    show "csr", SYST_CSR

    case "pending_while_masked"
    handler 15, once
    cpsid i
    start 20, ENABLE + TICKINT + CORE_CLOCK
    bl wait
    store SYST_CSR, CORE_CLOCK
    peek r4, ICSR
    and r4, #1 << 26
    note "pending", r4
    cpsie i
    isb

    case "no_interrupt_without_tickint"
    handler 15, once
    start 20, ENABLE + CORE_CLOCK
    bl wait
    store SYST_CSR, CORE_CLOCK
    peek r4, ICSR
    and r4, #1 << 26
    note "pending", r4

    case "reload_of_zero_stops"
    start 50, ENABLE + CORE_CLOCK
    bl short_wait
    store SYST_RVR, 0
    bl wait
    show "csr", SYST_CSR
    bl wait
    show "cvr", SYST_CVR
    show "csr", SYST_CSR
    store SYST_CSR, 0
    pop {r3-r7, pc}

@ Notes 1 if r5 is below r4.
    .thumb_func
is_below:
    push {r6, lr}
    movs r6, #0
    cmp r5, r4
    it lo
    movlo r6, #1
    note "below", r6
    pop {r6, pc}

@ Some thousand instructions.
    .thumb_func
wait:
    load r0, 4000
1:  subs r0, #1
    bne 1b
    bx lr

    .thumb_func
short_wait:
    nop
    bx lr

    .thumb_func
once:
    push {r4, lr}
    store SYST_CSR, CORE_CLOCK
    mrs r4, ipsr
    note "exception", r4
    show "icsr", ICSR
    pop {r4, pc}
