@ MPU, unprivileged code and unprivileged accesses.
    .include "macros.s"
    .text
    .equ NONE, 0 << 24              @ access of privileged and unprivileged code
    .equ PRIVILEGED, 1 << 24
    .equ READ_FOR_OTHERS, 2 << 24
    .equ FULL, 3 << 24
    .equ PRIVILEGED_READ, 5 << 24
    .equ READ, 6 << 24
    .equ NEVER, 1 << 28             @ no code
    .equ KIB, (9 << 1) + 1
    .equ ON, 1
    .equ IN_HARD_FAULT, 2
    .equ BACKGROUND, 4
    .equ HERE, DATA + 0x400         @ a KiB of RAM

    .macro region number, base, attributes
    store MPU_RBAR, (\base) + 0x10 + \number
    store MPU_RASR, \attributes
    .endm

    .macro protect control          @ flash for all code to read, the stacks and the lines for all to write; then the MPU goes on
    region 6, 0x08000000, READ + (15 << 1) + 1
    region 5, 0x20000000, FULL + (11 << 1) + 1
    region 4, 0x20004000, FULL + (12 << 1) + 1
    region 7, 0, 0
    store MPU_CTRL, \control
    dsb
    isb
    .endm

    .macro unprivileged
    movs r0, #1
    msr control, r0
    isb
    .endm

    .thumb_func
    .global protection_cases
protection_cases:
    push {r3-r7, lr}
    load r4, HERE

    case "mpu_type"
    show "type", MPU_TYPE
    region 3, HERE, READ + KIB
    store MPU_RNR, 3
    show "rbar", MPU_RBAR
    show "rasr", MPU_RASR
    show "alias", MPU_RBAR + 8

    case "no_access"
    region 0, HERE, NONE + KIB
    protect ON + BACKGROUND
    bl try_load
    bl try_store

    case "read_only"
    region 0, HERE, READ + KIB
    protect ON + BACKGROUND
    bl try_load
    bl try_store

    case "privileged_only"
    region 0, HERE, PRIVILEGED + KIB
    protect ON + BACKGROUND
    bl try_load
    bl try_store
    bl try_load_unprivileged
    bl try_store_unprivileged

    case "read_for_others"
    region 0, HERE, READ_FOR_OTHERS + KIB
    protect ON + BACKGROUND
    bl try_load_unprivileged
    bl try_store_unprivileged

    case "privileged_read"
    region 0, HERE, PRIVILEGED_READ + KIB
    protect ON + BACKGROUND
    bl try_load
    bl try_store
    bl try_load_unprivileged

    case "full_access_by_unprivileged_instructions"
    region 0, HERE, FULL + KIB
    protect ON + BACKGROUND
    bl try_load_unprivileged
    bl try_store_unprivileged

    case "no_background"
    region 0, HERE, FULL + KIB
    protect ON
    bl try_load
    adds r4, #0x400
    bl try_load
    sub r4, #0x400

    case "background_is_privileged"
    region 0, HERE, 0
    protect ON + BACKGROUND
    bl try_load
    bl try_load_unprivileged

    case "highest_region_decides"
    region 0, HERE, NONE + KIB
    region 1, HERE, FULL + (4 << 1) + 1     @ 32 bytes
    protect ON + BACKGROUND
    bl try_load
    adds r4, #32
    bl try_load
    sub r4, #32

    case "subregions"
    region 0, HERE, NONE + KIB
    region 1, HERE, FULL + (0xAA << 8) + KIB
    protect ON + BACKGROUND
    bl try_load
    adds r4, #128
    bl try_load
    adds r4, #128
    bl try_load
    sub r4, #256

    case "subregions_of_32_bytes"
    region 0, HERE, NONE + (2 << 8) + (7 << 1) + 1
    protect ON + BACKGROUND
    bl try_load
    adds r4, #64
    bl try_load
    sub r4, #64

    case "subregion_left_out"           @ a case of its own: QEMU keeps its answer for the whole page
    region 0, HERE, NONE + (2 << 8) + (7 << 1) + 1
    protect ON + BACKGROUND
    adds r4, #32
    bl try_load
    sub r4, #32

    case "unaligned_over_a_border"
    region 0, HERE, NONE + KIB
    protect ON + BACKGROUND
    subs r4, #2
    bl try_load
    adds r4, #2
    load r5, 0x3FE
    add r4, r5
    bl try_load
    subs r4, r5

    case "execute_never"
    region 0, HERE, FULL + NEVER + KIB
    bl put_code
    protect ON + BACKGROUND
    bl try_call
    store MPU_CTRL, 0
    dsb
    isb
    bl try_call

    case "execute_without_read"
    region 0, HERE, NONE + KIB
    bl put_code
    protect ON + BACKGROUND
    bl try_call

    case "execute_in_privileged_region"
    region 0, HERE, PRIVILEGED + KIB
    bl put_code
    protect ON + BACKGROUND
    bl try_call
    handler 11, become_privileged
    unprivileged
    bl try_call
    svc #0

    case "hard_fault_without_mpu"
    store SHCSR, 0
    region 0, HERE, NONE + KIB
    protect ON + BACKGROUND
    handler 3, load_in_hard_fault
    resume 1f
    udf #0
1:
    case "faultmask_without_mpu"
    region 0, HERE, NONE + KIB
    protect ON + BACKGROUND
    cpsid f
    ldr r5, [r4]
    cpsie f
    noted "no_fault", 0

    case "primask_with_mpu"
    region 0, HERE, NONE + KIB
    protect ON + BACKGROUND
    cpsid i
    bl try_load
    cpsie i

    case "stack_without_access"
    region 0, HERE, READ + KIB
    protect ON + BACKGROUND
    handler 4, recover_stack
    handler 16, record
    priority 0, 0x80
    resume 1f
    bl to_process_stack
    load r5, HERE + 0x100
    mov sp, r5
    pend 1
1:  bl to_main_stack

    case "stack_of_memory_fault"
    region 0, HERE, NONE + KIB
    protect ON + BACKGROUND
    handler 4, recover_stack
    resume 1f
    bl to_process_stack
    load r5, HERE + 0x100
    mov sp, r5
    push {r5}
1:  bl to_main_stack

    case "unprivileged_code"
    handler 11, become_privileged
    unprivileged
    mrs r5, control
    cpsid i
    movs r6, #0x80
    msr basepri, r6
    mrs r6, primask
    mrs r7, basepri
    svc #0
    note "control", r5
    note "primask", r6
    note "basepri", r7
    mrs r6, primask
    note "primask", r6
    mrs r7, basepri
    note "basepri", r7

    case "unprivileged_control"
    handler 11, become_privileged
    unprivileged
    movs r6, #0
    msr control, r6
    mrs r5, control
    mrs r6, msp
    mrs r7, psp
    svc #0
    note "control", r5
    note "msp", r6
    note "psp", r7

    case "unprivileged_system_registers"
    handler 11, become_privileged
    unprivileged
    load r4, CFSR
    resume 1f
    ldr r5, [r4]
1:  svc #0
    load r4, CFSR
    unprivileged
    resume 1f
    str r5, [r4]
1:  svc #0
    resume 1f
    load r4, CPUID
    ldrt r5, [r4]
1:  note "r4", r4

    case "unprivileged_software_trigger"
    handler 11, become_privileged
    unprivileged
    load r4, STIR
    movs r5, #2
    resume 1f
    str r5, [r4]
1:  svc #0
    store CCR, STKALIGN + 2             @ USERSETMPEND
    unprivileged
    str r5, [r4]
    dsb
    isb
    svc #0

    case "unprivileged_fpu"
    store CPACR, 0x00500000
    handler 11, become_privileged
    vmov s0, r0
    noted "privileged", 0
    unprivileged
    resume 1f
    vmov s0, r0
1:  svc #0

    pop {r3-r7, pc}

    .macro attempt instruction:vararg
    resume 1f
    \instruction
    noted "permitted", 0
1:  pop {r5, pc}
    .endm

    .thumb_func
try_load:
    push {r5, lr}
    attempt ldr r5, [r4]

    .thumb_func
try_store:
    push {r5, lr}
    attempt str r5, [r4]

    .thumb_func
try_load_unprivileged:
    push {r5, lr}
    attempt ldrt r5, [r4]

    .thumb_func
try_store_unprivileged:
    push {r5, lr}
    attempt strbt r5, [r4, #3]

@ Puts BX LR to the KiB.
    .thumb_func
put_code:
    load r5, 0x47704770
    str r5, [r4]
    dsb
    isb
    bx lr

    .thumb_func
try_call:
    push {r5, lr}
    add r5, r4, #1
    attempt blx r5

    .thumb_func
    .global become_privileged
become_privileged:
    movs r0, #0
    msr control, r0
    bx lr

    .thumb_func
load_in_hard_fault:
    ldr r0, [r4]
    noted "no_fault", 0
    b record

@ Notes the fault, and gives the process stack a frame that goes on at RESUME.
    .thumb_func
recover_stack:
    push {r4, lr}
    mrs r4, psp
    note "psp", r4
    mrs r4, ipsr
    note "exception", r4
    note "link", lr
    bl note_faults
    load r0, PROCESS_STACK - 32
    msr psp, r0
    peek r1, RESUME
    str r1, [r0, #24]
    load r1, 0x01000000
    str r1, [r0, #28]
    pop {r4, pc}
