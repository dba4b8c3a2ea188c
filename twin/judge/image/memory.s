@ Bit-band aliases, and identification.
    .include "macros.s"
    .text

    .macro alias reg, address, bit
    load \reg, ((\address) & 0xF0000000) + 0x02000000 + ((\address) & 0xFFFFF) * 32 + (\bit) * 4
    .endm

    .thumb_func
    .global memory_cases
memory_cases:
    push {r3-r7, lr}
    load r4, DATA

    case "bit_band_of_ram"
    load r5, 0x00000100
    str r5, [r4]
    alias r6, DATA + 1, 3
    movs r7, #1
    str r7, [r6]
    ldr r5, [r4]
    note "set", r5
    alias r6, DATA + 1, 0
    ldr r5, [r6]
    note "load", r5
    movs r7, #2                         @ bit 0 counts
    str r7, [r6]
    ldr r5, [r4]
    note "cleared", r5
    ldr r5, [r6]
    note "load", r5

    case "bit_band_of_narrow_accesses"
    load r5, 0xFFFFFFFF
    str r5, [r4]
    alias r6, DATA + 2, 6
    movs r7, #0
    strb r7, [r6]
    ldr r5, [r4]
    note "byte", r5
    alias r6, DATA + 3, 7
    strh r7, [r6]
    ldr r5, [r4]
    note "half", r5
    ldrb r5, [r6]
    note "load_byte", r5
    ldrsh r5, [r6]
    note "load_half", r5

    case "bit_band_of_peripheral"
    load r4, PERIPHERAL
    movs r5, #0x11
    str r5, [r4]
    alias r6, PERIPHERAL, 5
    movs r7, #1
    str r7, [r6]
    ldr r5, [r4]
    note "set", r5
    ldr r5, [r6]
    note "load", r5
    alias r6, PERIPHERAL, 0
    movs r7, #0
    str r7, [r6]
    ldr r5, [r4]
    note "cleared", r5

    case "bit_band_without_memory"
    alias r6, 0x200F0000, 0
    resume 1f
    ldr r5, [r6]
1:  resume 1f
    str r5, [r6]
1:
    case "special_registers"
    load r5, 0xFFFFFFFF
    msr apsr_nzcvqg, r5
    mrs r5, apsr
    note "apsr", r5
    load r5, 0xFFFFFFFF
    msr primask, r5
    mrs r5, primask
    note "primask", r5
    cpsie i
    mrs r5, control
    note "control", r5
    load r5, 0x12345673
    msr psp, r5
    mrs r5, psp
    note "psp", r5
    mrs r5, iapsr
    load r6, 0x1FF
    ands r5, r6
    note "ipsr", r5

    case "identification"
    show "mvfr0", 0xE000EF40
    show "mvfr1", 0xE000EF44
    show "ccr", CCR
    show "aircr", AIRCR
    pop {r3-r7, pc}
