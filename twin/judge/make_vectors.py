"""Makes twin/tests/vectors/unicorn.bin: instructions from random states, and the answers of Unicorn.

States come from a generator that tests/vectors.rs repeats, so that the file holds encodings and answers alone. See README.md.

usage: make_vectors.py [count [seed [output]]]
"""

import itertools
import pathlib
import random
import struct
import sys

import unicorn
from unicorn import arm_const as arm

import t32

FLASH, RAM, SIZE = 0x08000000, 0x20000000, 0x1000
CODE, STACK = FLASH + 0x800, RAM + 0x800
WORD = (1 << 64) - 1
FPSCR_BITS = 0xF7C0009F
SPECIALS = [0, 0x80000000, 1, 0x80000001, 0x007FFFFF, 0x00800000, 0x3F800000, 0xBF800000, 0x7F7FFFFF, 0xFF7FFFFF,
            0x7F800000, 0xFF800000, 0x7FC00001, 0xFFC12345, 0x7F800001, 0xFFA00000]
CORE = [getattr(arm, f"UC_ARM_REG_R{k}") for k in range(13)] + [arm.UC_ARM_REG_SP, arm.UC_ARM_REG_LR]
SINGLE = [getattr(arm, f"UC_ARM_REG_S{k}") for k in range(32)]
APSR = 0xF80F0000
NONE = 0xFF
LOADS_PC = {name for kind, name, _, _ in t32.TABLE if kind == "B"}
# Conditions on a state: an aligned base, rounding to nearest, the address of Thumb code in a register.
ALIGNED, TO_NEAREST, TARGET, RMODE = 1, 2, 4, 3 << 22


class Generator:
    """xorshift64, as in tests/vectors.rs."""

    def __init__(self, index):
        self.state = (index + 1) * 0x9E3779B97F4A7C15 & WORD

    def next(self):
        self.state ^= self.state << 13 & WORD
        self.state ^= self.state >> 7
        self.state ^= self.state << 17 & WORD
        return self.state >> 16 & 0xFFFFFFFF


def memory(index):
    generator = Generator(index)
    return b"".join(struct.pack("<I", generator.next()) for _ in range(SIZE // 4))


def state(index, base, register, shape):
    """Core registers, APSR, FPU registers and FPSCR of one vector."""
    generator = Generator(index)
    core = []
    for _ in range(15):
        kind, value = generator.next() % 8, generator.next()
        core.append([value, value % 64, 0x80000000, 0xFFFFFFFF, 0x7FFFFFFF, 0, value, value][kind])
    core[13] = STACK
    place, offset = generator.next(), generator.next()
    if base != NONE:
        core[base] = RAM + 0x600 + place % 0x200
        if shape & ALIGNED:
            core[base] &= ~3
    if register != NONE:
        core[register] = offset & 0x1FFFFFFF | 1 if shape & TARGET else offset % 0x40
    apsr = generator.next() & APSR
    single = []
    for _ in range(32):
        kind, value, other = generator.next() % 8, generator.next(), generator.next()
        if kind == 0:
            single.append(SPECIALS[other % 16])
        elif kind == 1:
            single.append(value & 0x807FFFFF)
        elif kind == 2:
            single.append(value)
        elif kind == 3:
            single.append(value & 0x807FFFFF | (other % 254 + 1) << 23)
        else:
            single.append(value & 0x807FFFFF | (other % 24 + 116) << 23)
    kind, value = generator.next() % 2, generator.next()
    fpscr = value & FPSCR_BITS if kind else 0
    return core, apsr, single, fpscr & ~RMODE if shape & TO_NEAREST else fpscr


def draw(chance, bits, rule):
    """Half-words of an encoding with random fields, and its fields."""
    while True:
        fields, word = {}, 0
        for letter in bits:
            bit = int(letter) if letter in "01" else chance.getrandbits(1)
            word = word << 1 | bit
            if letter not in "01":
                fields[letter] = fields.get(letter, 0) << 1 | bit
        if rule(fields):
            if len(bits) == 16:
                return [word], fields
            return [word >> 16, word & 0xFFFF], fields


class Judge:
    """A Cortex-M4 of Unicorn with both memories."""

    def __init__(self, flash, ram):
        self.flash, self.ram = flash, ram
        self.uc = unicorn.Uc(unicorn.UC_ARCH_ARM, unicorn.UC_MODE_THUMB | unicorn.UC_MODE_MCLASS)
        self.uc.ctl_set_cpu_model(arm.UC_CPU_ARM_CORTEX_M4)
        self.uc.mem_map(FLASH, SIZE)
        self.uc.mem_map(RAM, SIZE)
        self.uc.mem_write(FLASH, flash)
        # VMRS r0, FPSCR: the first instruction of the FPU sets FPSCR to FPDSCR (A2.5.4).
        self.run([0xEEF1, 0x0A10], 1, ([0] * 15, 0, [0] * 32, 0))

    def is_thumb(self):
        return self.uc.reg_read(arm.UC_ARM_REG_XPSR) >> 24 & 1 == 1

    def run(self, code, count, inputs):
        core, apsr, single, fpscr = inputs
        uc = self.uc
        uc.mem_write(CODE, struct.pack(f"<{len(code)}H", *code))
        uc.ctl_remove_cache(CODE, CODE + 32)
        uc.mem_write(RAM, self.ram)
        for register, value in zip(CORE, core):
            uc.reg_write(register, value)
        for register, value in zip(SINGLE, single):
            uc.reg_write(register, value)
        uc.reg_write(arm.UC_ARM_REG_FPSCR, fpscr)
        uc.reg_write(arm.UC_ARM_REG_XPSR_NZCVQG, apsr | 1 << 24)
        if count == 1:
            try:
                uc.emu_start(CODE | 1, 0xFFFFFFFF, count=1)
            except unicorn.UcError as error:
                # A branch to where there is no memory: it has happened, the instruction there has not.
                if error.errno != unicorn.UC_ERR_FETCH_UNMAPPED:
                    raise
        else:
            # Unicorn does not count inside of an IT block.
            uc.emu_start(CODE | 1, CODE + 2 * len(code))
        result = (
            [uc.reg_read(register) for register in CORE],
            uc.reg_read(arm.UC_ARM_REG_PC),
            uc.reg_read(arm.UC_ARM_REG_XPSR) & APSR,
            [uc.reg_read(register) for register in SINGLE],
            uc.reg_read(arm.UC_ARM_REG_FPSCR),
            bytes(uc.mem_read(RAM, SIZE)),
        )
        # Restores the flash for the next vector.
        uc.mem_write(CODE, self.flash[CODE - FLASH:CODE - FLASH + 32])
        return result


def runs(old, new):
    """Where bytes differ: offsets and the new bytes."""
    found = []
    lines = (line for line in range(0, SIZE, 64) if old[line:line + 64] != new[line:line + 64])
    for at in (at for line in lines for at in range(line, line + 64) if old[at] != new[at]):
        if found and found[-1][0] + len(found[-1][1]) == at and len(found[-1][1]) < 255:
            found[-1][1].append(new[at])
        else:
            found.append((at, bytearray([new[at]])))
    return found


def pack(code, count, base, register, shape, inputs, answer, ram):
    core, pc, apsr, single, fpscr, after = answer
    out = struct.pack("<BBBBB", len(code), count, base, register, shape)
    out += struct.pack(f"<{len(code)}H", *code)
    for before, values, form in ((inputs[0], core, "<H"), (inputs[2], single, "<I")):
        changed = [k for k, value in enumerate(values) if value != before[k]]
        out += struct.pack(form, sum(1 << k for k in changed))
        out += b"".join(struct.pack("<I", values[k]) for k in changed)
    out += struct.pack("<III", pc, apsr, fpscr)
    writes = runs(ram, after)
    out += struct.pack("<B", len(writes))
    return out + b"".join(struct.pack("<HB", at, len(data)) + bytes(data) for at, data in writes)


def block(chance):
    """An IT block of one to four instructions that leave the flow and PC alone."""
    plain = [entry for entry in t32.TABLE if entry[0] == "R" and not entry[1].startswith(("B", "CB", "TB", "ISB", "MOVS reg", "MOV pc", "ADD pc"))
             or entry[1].startswith(("BIC", "BFI", "BFC"))]
    length = chance.randrange(1, 5)
    condition = chance.randrange(15)
    same, other = condition & 1, ~condition & 1
    picks = [same if condition == 14 else chance.choice((same, other)) for _ in range(length - 1)]
    mask = 0
    for bit in picks + [1]:
        mask = mask << 1 | bit
    mask <<= 4 - length
    code = [0xBF00 | condition << 4 | mask]
    for _ in range(length):
        _, _, bits, rule = chance.choice(plain)
        code += draw(chance, bits, rule)[0]
    return code, length + 1


def exclusive(chance):
    """A load-exclusive, or CLREX in its place, and the store-exclusive to the same address. Answers the base, too."""
    base, source, loaded, status = chance.sample([reg for reg in range(15) if reg != 13], 4)
    offset = chance.getrandbits(8)
    load, store = chance.choice((
        ([0xE850 | base, loaded << 12 | 0xF00 | offset], [0xE840 | base, source << 12 | status << 8 | offset]),
        ([0xE8D0 | base, loaded << 12 | 0xF4F], [0xE8C0 | base, source << 12 | 0xF40 | status]),
        ([0xE8D0 | base, loaded << 12 | 0xF5F], [0xE8C0 | base, source << 12 | 0xF50 | status]),
    ))
    return chance.choice((load, [0xF3BF, 0x8F2F])) + store, base


def choose(chance, index):
    """The encoding of a vector and the conditions on its state: all encodings in turn.

    Every tenth is an IT block, and every fiftieth a store-exclusive with what precedes it.
    """
    if index % 10 == 9:
        code, steps = block(chance)
        return "IT block", code, steps, NONE, NONE, 0
    if index % 50 == 4:
        code, base = exclusive(chance)
        return "STREX", code, 2, base, NONE, ALIGNED
    kind, name, bits, rule = t32.TABLE[(index - index // 10) % len(t32.TABLE)]
    code, fields = draw(chance, bits, rule)
    base = fields.get("n", NONE) if kind in "BMD" else NONE
    register = fields.get("m", NONE) if kind in "BM" else NONE
    if name in ("BX", "BLX", "MOV pc"):
        return name, code, 1, NONE, fields["m"], TARGET
    shape = ALIGNED if kind in "BD" or name in ("STM 16", "LDM 16") else TO_NEAREST if kind == "N" else 0
    return name, code, 1, base, register, shape


def main():
    count = int(sys.argv[1]) if len(sys.argv) > 1 else 20_000
    seed = int(sys.argv[2]) if len(sys.argv) > 2 else 1
    default = pathlib.Path(__file__).parent.parent / "tests" / "vectors" / "unicorn.bin"
    output = pathlib.Path(sys.argv[3]) if len(sys.argv) > 3 else default
    chance = random.Random(seed)
    flash, ram = memory(1 << 32), memory(1 << 33)
    judge = Judge(flash, ram)
    blocks = 0
    vectors = []
    for index in range(count):
        for attempt in itertools.count():
            # A load to PC may find no address of code whatever its fields are. Then the next encoding takes its place.
            name, code, steps, base, register, shape = choose(chance, index + attempt // 20)
            inputs = state(seed << 40 | index, base, register, shape)
            loads_pc = name in LOADS_PC
            try:
                answer = judge.run(code, steps, inputs)
                if not loads_pc or judge.is_thumb():
                    break
            except unicorn.UcError as error:
                # A target in a region that holds no code raises an exception at once.
                if name != "ADD pc" and not loads_pc:
                    sys.exit(f"vector {index}, {name}: {' '.join(f'{half:04X}' for half in code)}: {error}")
        blocks += name == "IT block"
        vectors.append(pack(code, steps, base, register, shape, inputs, answer, ram))
    output.parent.mkdir(exist_ok=True)
    output.write_bytes(struct.pack("<IQ", count, seed) + b"".join(vectors))
    print(f"{count} vectors, {blocks} of them IT blocks, {len(t32.TABLE)} encodings: {output.stat().st_size} bytes")


main()
