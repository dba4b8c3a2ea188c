@ Start, the lines of output, and the handler that most cases use.
@
@ Each line of output is: case, number of the line in the case, name, value. Semihosting prints it.
    .include "macros.s"

    .section .vectors, "a"
    .word MAIN_STACK
    .word reset
    .rept 62
    .word record
    .endr

    .text
    .thumb_func
    .global reset
reset:
    load r4, MAIN_STACK
    mov sp, r4
    bl exception_cases
    bl priority_cases
    bl return_cases
    bl fault_cases
    bl stacking_cases
    bl lazy_cases
    bl protection_cases
    bl memory_cases
    bl systick_cases
    case "end"
    bl begin_case                   @ prints the last lines
    movs r0, #0x18                  @ SYS_EXIT
    load r1, 0x20026                @ ADP_Stopped_ApplicationExit
    bkpt #0xAB
    b .

@ Prints the lines of the case before; r0 is the name of the new one. Brings the core to a known state: faults enabled, priorities 0,
@ interrupts 0 to 7 enabled and none pending, FPU on and without a context, MPU off, every vector `record`.
    .thumb_func
    .global begin_case
begin_case:
    push {r4-r7, lr}
    mov r4, r0
    cpsie if
    movs r0, #0
    msr basepri, r0
    msr control, r0
    isb
    store MPU_CTRL, 0
    load r0, MPU_RBAR
    movs r1, #0x17                  @ region 7, then the others
    movs r2, #0
1:  str r1, [r0]
    str r2, [r0, #4]
    subs r1, #1
    cmp r1, #0x10
    bhs 1b
    store SYST_CSR, 0
    store CCR, STKALIGN
    store AIRCR, 0x05FA0000
    store SHCSR, ALL_FAULTS
    store NVIC_ICPR, 0xFFFFFFFF
    store NVIC_ICER, 0xFFFFFFFF
    store NVIC_ISER, 0xFF
    store CFSR, 0xFFFFFFFF
    store HFSR, 0xFFFFFFFF
    store CPACR, 0x00F00000
    store FPCCR, 0xC0000000
    store FPDSCR, 0
    dsb
    isb
    movs r1, #0
    load r0, NVIC_IPR
    str r1, [r0], #4
    str r1, [r0]
    load r0, SHPR
    str r1, [r0], #4
    str r1, [r0], #4
    str r1, [r0]
    load r0, VECTORS
    load r1, record
    movs r2, #64
1:  str r1, [r0], #4
    subs r2, #1
    bne 1b
    store RESUME, 0
    store VTOR, VECTORS
    bl print_lines
    load r0, CASE
    str r4, [r0]
    ldr r1, [sp, #16]               @ LR: the first instruction of the case
    bic r1, #1
    load r0, ORIGIN
    str r1, [r0]
    store LINES_END, LINES
    @ Same values in the registers that cases look at.
    movs r0, #0
    vmsr fpscr, r0
    clrex
    msr control, r0
    isb
    msr apsr_nzcvqg, r0
    pop {r4-r7, pc}

@ Adds a line with the name r0 and the value r1.
    .thumb_func
    .global add_line
add_line:
    load r2, LINES_END
    ldr r3, [r2]
    str r0, [r3]
    str r1, [r3, #4]
    adds r3, #8
    str r3, [r2]
    bx lr

    .thumb_func
print_lines:
    push {r4-r7, lr}
    peek r5, LINES_END
    load r4, LINES
    cmp r5, #0                      @ before the first case
    beq 9f
1:  cmp r4, r5
    bhs 9f
    load r6, TEXT
    peek r0, CASE
    bl copy
    movs r0, #' '
    strb r0, [r6], #1
    load r0, LINES
    subs r0, r4, r0
    lsrs r0, r0, #3
    movs r1, #2
    bl digits
    movs r0, #' '
    strb r0, [r6], #1
    ldr r0, [r4], #4
    bl copy
    movs r0, #' '
    strb r0, [r6], #1
    ldr r0, [r4], #4
    movs r1, #8
    bl digits
    movs r0, #'\n'
    strb r0, [r6], #1
    movs r0, #0
    strb r0, [r6]
    movs r0, #4                     @ SYS_WRITE0
    load r1, TEXT
    bkpt #0xAB
    b 1b
9:  pop {r4-r7, pc}

@ Copies the text r0 to r6.
copy:
    ldrb r1, [r0], #1
    cbz r1, 1f
    strb r1, [r6], #1
    b copy
1:  bx lr

@ Writes r0 as r1 hexadecimal digits to r6.
digits:
    lsls r2, r1, #2
    subs r2, #4
1:  lsr r3, r0, r2
    and r3, #15
    cmp r3, #10
    ite lo
    addlo r3, #'0'
    addhs r3, #'A' - 10
    strb r3, [r6], #1
    subs r2, #4
    bpl 1b
    bx lr

@ Notes the exception, EXC_RETURN, the address of the frame, its PC and xPSR, and the faults. A PC in flash is noted as its distance
@ from the beginning of the case. Returns, to RESUME if that is not zero.
    .thumb_func
    .global record
record:
    tst lr, #4
    ite eq
    mrseq r0, msp
    mrsne r0, psp
    push {r4-r6, lr}
    mov r4, r0
    mov r5, lr
    mrs r6, ipsr
    note "exception", r6
    note "link", r5
    note "frame", r4
    ldr r6, [r4, #24]
    lsrs r0, r6, #24
    cmp r0, #8
    bne 1f
    peek r0, ORIGIN
    subs r6, r0
1:  note "pc", r6
    ldr r6, [r4, #28]
    note "psr", r6
    bl note_faults
    load r0, RESUME
    ldr r1, [r0]
    cbz r1, 1f
    movs r2, #0
    str r2, [r0]
    str r1, [r4, #24]
    bic r6, #0x06000000             @ no IT block, no multiple transfer, Thumb
    bic r6, #0x0000FC00
    orr r6, #0x01000000
    str r6, [r4, #28]
1:  pop {r4-r6, pc}

@ Notes CFSR and HFSR if they are not zero, and the addresses that CFSR calls valid. Clears the faults.
    .thumb_func
    .global note_faults
note_faults:
    push {r4, r5, lr}
    peek r4, CFSR
    cbz r4, 1f
    note "cfsr", r4
1:  peek r5, HFSR
    cbz r5, 2f
    note "hfsr", r5
2:  lsls r5, r4, #24
    bpl 3f
    show "mmfar", MMFAR
3:  lsls r5, r4, #16
    bpl 4f
    show "bfar", BFAR
4:  store CFSR, 0xFFFFFFFF
    store HFSR, 0xFFFFFFFF
    pop {r4, r5, pc}
