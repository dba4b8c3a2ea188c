@ Entry and return, pending bits, masks, exclusive monitor.
    .include "macros.s"
    .text
    .thumb_func
    .global exception_cases
exception_cases:
    push {r3-r7, lr}

    case "svc"
    svc #7

    case "svc_in_it_block"
    movs r5, #0
    cmp r5, #0
    ittet eq
    svceq #1
    moveq r5, #1
    movne r5, #2
    addeq r5, #4
    note "r5", r5

    case "pendsv"
    store ICSR, PENDSVSET
    dsb
    isb

    case "interrupt"
    pend 1 << 3
    show "ispr", NVIC_ISPR

    case "software_trigger"
    store STIR, 5
    dsb
    isb

    case "nmi"
    store ICSR, NMIPENDSET
    dsb
    isb

    case "pending_cleared"
    cpsid i
    store ICSR, PENDSVSET
    show "shcsr", SHCSR
    show "icsr", ICSR
    store ICSR, PENDSVSET >> 1
    store ICSR, 1 << 26
    show "systick_pending", ICSR
    store ICSR, 1 << 25
    pend 0x05
    show "icsr", ICSR
    show "ispr", NVIC_ISPR
    store NVIC_ICPR, 0x04
    store NVIC_ICER, 0x01
    cpsie i
    isb
    show "icsr_disabled", ICSR
    store NVIC_ISER, 0x01
    dsb
    isb

    case "primask"
    cpsid i
    pend 1 << 2
    noted "masked", 0
    mrs r4, primask
    note "primask", r4
    cpsie i
    isb

    case "faultmask"
    cpsid f
    pend 1 << 2
    mrs r4, faultmask
    note "faultmask", r4
    store ICSR, NMIPENDSET          @ returning from NMI keeps FAULTMASK
    dsb
    isb
    mrs r4, faultmask
    note "after_nmi", r4
    cpsie f
    isb

    case "faultmask_cleared_by_return"
    handler 16, set_faultmask
    pend 1
    mrs r4, faultmask
    note "after_return", r4

    case "basepri"
    priority 0, 0x80
    priority 1, 0x90
    priority 2, 0x70
    movs r4, #0x80
    msr basepri, r4
    pend 0x07
    noted "masked", 0
    movs r4, #0x90
    msr basepri_max, r4             @ lower: no effect
    mrs r5, basepri
    note "basepri", r5
    movs r4, #0x40
    msr basepri_max, r4
    mrs r5, basepri
    note "basepri", r5
    movs r4, #0x90
    msr basepri, r4
    isb
    noted "ninety_masked", 0
    movs r4, #0
    msr basepri, r4
    isb

    case "interrupted_it_block"
    priority 0, 0x80
    load r0, NVIC_ISPR
    movs r1, #1
    movs r2, #0
    movs r3, #0
    cmp r2, #0
    itete eq
    streq r1, [r0]
    movne r2, #1
    moveq r3, #2
    addne r3, #4
    note "r2", r2
    note "r3", r3

    case "interrupted_it_block_of_failing_condition"
    load r0, NVIC_ISPR
    movs r1, #1
    movs r3, #0
    cmp r3, #1
    ittet ne
    strne r1, [r0]
    movne r3, #2
    moveq r3, #9
    addne r3, #4
    note "r3", r3

    case "context_is_kept"
    handler 16, destroy
    load r0, NVIC_ISPR
    movs r1, #1
    load r2, 0x22222222
    load r3, 0x33333333
    load r4, 0xCCCCCCCC
    mov r12, r4
    load r4, 0xEEEEEEEF
    mov lr, r4
    load r4, 0xF80F0000
    msr apsr_nzcvqg, r4
    str r1, [r0]
    dsb
    isb
    mrs r5, apsr
    mov r4, lr
    note "r1", r1
    note "r2", r2
    note "r3", r3
    note "lr", r4
    mov r4, r12
    note "r12", r4
    note "apsr", r5

    case "control_in_handler"
    handler 11, select_process_stack
    svc #0
    mrs r4, control
    note "after", r4

    case "exclusive_monitor"
    load r4, DATA
    movs r5, #7
    ldrex r6, [r4]
    strex r6, r5, [r4]
    note "undisturbed", r6
    ldrex r6, [r4]
    svc #0
    strex r6, r5, [r4]
    note "after_exception", r6
    ldrex r6, [r4]
    clrex
    strex r6, r5, [r4]
    note "after_clrex", r6
    ldrexb r6, [r4]
    strexb r6, r5, [r4]
    note "byte", r6
    ldrexh r6, [r4]
    strexh r6, r5, [r4]
    note "half", r6
    strexh r6, r5, [r4]
    note "again", r6

    case "handler_state"
    handler 11, note_state
    handler 14, note_state
    handler 15, note_state
    handler 18, note_state
    svc #0
    store ICSR, PENDSVSET
    dsb
    isb
    store ICSR, 1 << 26
    dsb
    isb
    pend 1 << 2

    case "pended_by_shcsr"
    store SHCSR, ALL_FAULTS + (1 << 12)
    dsb
    isb
    store SHCSR, ALL_FAULTS + (1 << 15)
    dsb
    isb

    case "wfi_with_pending_interrupt"
    cpsid i
    pend 1 << 1
    wfi
    noted "awake", 1
    cpsie i
    isb

    pop {r3-r7, pc}

    .thumb_func
set_faultmask:
    push {r4, lr}
    cpsid f
    mrs r4, faultmask
    note "in_handler", r4
    pop {r4, pc}

    .thumb_func
select_process_stack:                   @ Handler mode keeps the main stack
    push {r4, lr}
    movs r4, #2
    msr control, r4
    isb
    mrs r4, control
    note "in_handler", r4
    pop {r4, pc}

    .thumb_func
destroy:
    movs r0, #0
    mov r1, r0
    mov r2, r0
    mov r3, r0
    mov r12, r0
    msr apsr_nzcvqg, r0
    bx lr

    .thumb_func
note_state:
    push {r4, lr}
    show "icsr", ICSR
    show "shcsr", SHCSR
    show "iabr", NVIC_IABR
    mrs r4, ipsr
    note "ipsr", r4
    mrs r4, xpsr                    @ execution bits read as zero
    and r4, #0xFF000000
    bic r4, #0xF8000000
    note "epsr", r4
    pop {r4, pc}
