"""Encodings of the Cortex-M4's instructions, written from DDI 0403E chapters A5 to A7.

Each line is a name, one or two half-words of bits and letters, and a rule. A letter is a field; its bits may stand apart, the highest
first. A rule refuses fields for which the manual calls the encoding UNPREDICTABLE. Registers: d, n, m, t, a, and u (a second one).
Kinds: R works on registers, B loads PC, M accesses memory at the base n (with the index m, if there is one), D does so with an aligned base, S at
SP, L at PC, F works on the FPU, N does so and rounds to nearest.
"""


def ok(*regs):
    """No register is SP or PC."""
    return all(reg not in (13, 15) for reg in regs)


def low(field):
    return field < 8


TABLE = []


def add(kind, name, bits, rule=lambda f: True):
    TABLE.append((kind, name, bits.replace(" ", ""), rule))


def always(_):
    return True


# 16 bits (A5.2).
add("R", "LSL imm", "00000 iiiii mmm ddd", lambda f: f["i"] != 0)
add("R", "MOVS reg", "00000 00000 mmm ddd")
add("R", "LSR imm", "00001 iiiii mmm ddd")
add("R", "ASR imm", "00010 iiiii mmm ddd")
add("R", "ADD reg", "0001100 mmm nnn ddd")
add("R", "SUB reg", "0001101 mmm nnn ddd")
add("R", "ADD imm3", "0001110 iii nnn ddd")
add("R", "SUB imm3", "0001111 iii nnn ddd")
add("R", "MOV imm8", "00100 ddd iiiiiiii")
add("R", "CMP imm8", "00101 nnn iiiiiiii")
add("R", "ADD imm8", "00110 ddd iiiiiiii")
add("R", "SUB imm8", "00111 ddd iiiiiiii")
for op, name in enumerate("AND EOR LSL LSR ASR ADC SBC ROR TST RSB CMP CMN ORR MUL BIC MVN".split()):
    add("R", f"{name} 16", f"010000 {op:04b} mmm ddd")
# Not to SP: Unicorn keeps bits 1:0 of the result, which are zero in SP (B1.4.1).
add("R", "ADD high", "01000100 d mmmm ddd", lambda f: ok(f["d"]) and f["m"] != 15)
add("R", "CMP high", "01000101 n mmmm nnn", lambda f: f["n"] != 15 and f["m"] != 15 and (f["n"] >= 8 or f["m"] >= 8))
add("R", "MOV high", "01000110 d mmmm ddd", lambda f: ok(f["d"]))
add("R", "MOV pc", "01000110 1 mmmm 111", lambda f: ok(f["m"]))
add("R", "ADD pc", "01000100 1 mmmm 111", lambda f: ok(f["m"]))
add("L", "LDR literal 16", "01001 ttt 0iiiiiii")
for op, name in enumerate("STR STRH STRB LDRSB LDR LDRH LDRB LDRSH".split()):
    add("M", f"{name} reg 16", f"0101 {op:03b} mmm nnn ttt", lambda f: f["m"] != f["n"])
for op, name in enumerate("STR LDR STRB LDRB STRH LDRH".split()):
    add("M", f"{name} imm5", f"{0b01100 + op:05b} iiiii nnn ttt")
add("S", "STR sp", "10010 ttt 0iiiiiii")
add("S", "LDR sp", "10011 ttt 0iiiiiii")
add("R", "ADR 16", "10100 ddd iiiiiiii")
add("R", "ADD rd sp", "10101 ddd iiiiiiii")
add("R", "ADD sp imm7", "10110000 0 iiiiiii")
add("R", "SUB sp imm7", "10110000 1 iiiiiii")
for op, name in enumerate("SXTH SXTB UXTH UXTB".split()):
    add("R", f"{name} 16", f"10110010 {op:02b} mmm ddd")
add("R", "CBZ", "1011 0 0 i 1 iiiii nnn")
add("R", "CBNZ", "1011 1 0 i 1 iiiii nnn")
add("S", "PUSH", "1011010 r rrrrrrrr", lambda f: f["r"] != 0)
add("S", "POP", "1011110 0 rrrrrrrr", lambda f: f["r"] != 0)
for op, name in ((0, "REV"), (1, "REV16"), (3, "REVSH")):
    add("R", f"{name} 16", f"10111010 {op:02b} mmm ddd")
add("R", "NOP 16", "10111111 00000000")
add("M", "STM 16", "11000 nnn rrrrrrrr", lambda f: f["r"] != 0 and not f["r"] >> f["n"] & 1)
add("M", "LDM 16", "11001 nnn rrrrrrrr", lambda f: f["r"] != 0)
add("R", "B cond 16", "1101 cccc iiiiiiii", lambda f: f["c"] < 14)
add("R", "B 16", "11100 iiiiiiiiiii")

# Data processing with a constant (A5.3.1 to A5.3.3).
def modified(f):
    return f["i"] & 0xFF != 0 or f["i"] >> 8 & 0xF not in (1, 2, 3)


for op, name in ((0, "AND"), (1, "BIC"), (2, "ORR"), (3, "ORN"), (4, "EOR"), (8, "ADD"), (10, "ADC"), (11, "SBC"), (13, "SUB"), (14, "RSB")):
    add("R", f"{name} imm", f"11110 i 0 {op:04b} s nnnn 0 iii dddd iiiiiiii", lambda f: ok(f["d"], f["n"]) and modified(f))
    add("R", f"{name} shifted", f"1110101 {op:04b} s nnnn 0 iii dddd iikk mmmm", lambda f: ok(f["d"], f["n"], f["m"]))
for op, name in ((0, "TST"), (4, "TEQ"), (8, "CMN"), (13, "CMP")):
    add("R", f"{name} imm", f"11110 i 0 {op:04b} 1 nnnn 0 iii 1111 iiiiiiii", lambda f: ok(f["n"]) and modified(f))
    add("R", f"{name} shifted", f"1110101 {op:04b} 1 nnnn 0 iii 1111 iikk mmmm", lambda f: ok(f["n"], f["m"]))
for op, name in ((2, "MOV"), (3, "MVN")):
    add("R", f"{name} imm", f"11110 i 0 {op:04b} s 1111 0 iii dddd iiiiiiii", lambda f: ok(f["d"]) and modified(f))
    add("R", f"{name} shifted", f"1110101 {op:04b} s 1111 0 iii dddd iikk mmmm", lambda f: ok(f["d"], f["m"]))
# RRX, which the shifts above seldom are.
for op, name in enumerate("AND BIC ORR ORN EOR".split() + 3 * [None] + ["ADD", None, "ADC", "SBC", None, "SUB", "RSB"]):
    if name:
        add("R", f"{name} rrx", f"1110101 {op:04b} s nnnn 0 000 dddd 0011 mmmm", lambda f: ok(f["d"], f["n"], f["m"]))
for op, name in ((0, "TST"), (4, "TEQ"), (8, "CMN"), (13, "CMP")):
    add("R", f"{name} rrx", f"1110101 {op:04b} 1 nnnn 0 000 1111 0011 mmmm", lambda f: ok(f["n"], f["m"]))
for op, name in ((2, "MOV"), (3, "MVN")):
    add("R", f"{name} rrx", f"1110101 {op:04b} s 1111 0 000 dddd 0011 mmmm", lambda f: ok(f["d"], f["m"]))
add("R", "ADD sp imm", "11110 i 0 1000 s 1101 0 iii dddd iiiiiiii", lambda f: ok(f["d"]) and modified(f))
add("R", "SUB sp imm", "11110 i 0 1101 s 1101 0 iii dddd iiiiiiii", lambda f: ok(f["d"]) and modified(f))
add("R", "ADD sp shifted", "1110101 1000 s 1101 0 iii dddd iikk mmmm", lambda f: ok(f["d"], f["m"]))
add("R", "SUB sp shifted", "1110101 1101 s 1101 0 iii dddd iikk mmmm", lambda f: ok(f["d"], f["m"]))
add("R", "ADDW", "11110 i 100000 nnnn 0 iii dddd iiiiiiii", lambda f: ok(f["d"], f["n"]))
add("R", "SUBW", "11110 i 101010 nnnn 0 iii dddd iiiiiiii", lambda f: ok(f["d"], f["n"]))
add("R", "ADR after", "11110 i 100000 1111 0 iii dddd iiiiiiii", lambda f: ok(f["d"]))
add("R", "ADR before", "11110 i 101010 1111 0 iii dddd iiiiiiii", lambda f: ok(f["d"]))
add("R", "MOVW", "11110 i 100100 iiii 0 iii dddd iiiiiiii", lambda f: ok(f["d"]))
add("R", "MOVT", "11110 i 101100 iiii 0 iii dddd iiiiiiii", lambda f: ok(f["d"]))
add("R", "SSAT lsl", "11110 0 110000 nnnn 0 iii dddd ii 0 bbbbb", lambda f: ok(f["d"], f["n"]))
add("R", "SSAT asr", "11110 0 110010 nnnn 0 iii dddd ii 0 bbbbb", lambda f: ok(f["d"], f["n"]) and f["i"] != 0)
add("R", "SSAT16", "11110 0 110010 nnnn 0 000 dddd 00 00 bbbb", lambda f: ok(f["d"], f["n"]))
add("R", "USAT lsl", "11110 0 111000 nnnn 0 iii dddd ii 0 bbbbb", lambda f: ok(f["d"], f["n"]))
add("R", "USAT asr", "11110 0 111010 nnnn 0 iii dddd ii 0 bbbbb", lambda f: ok(f["d"], f["n"]) and f["i"] != 0)
add("R", "USAT16", "11110 0 111010 nnnn 0 000 dddd 00 00 bbbb", lambda f: ok(f["d"], f["n"]))
add("R", "SBFX", "11110 0 110100 nnnn 0 iii dddd ii 0 bbbbb", lambda f: ok(f["d"], f["n"]) and f["i"] + f["b"] < 32)
add("R", "UBFX", "11110 0 111100 nnnn 0 iii dddd ii 0 bbbbb", lambda f: ok(f["d"], f["n"]) and f["i"] + f["b"] < 32)
add("R", "BFI", "11110 0 110110 nnnn 0 iii dddd ii 0 bbbbb", lambda f: ok(f["d"], f["n"]) and f["b"] >= f["i"])
add("R", "BFC", "11110 0 110110 1111 0 iii dddd ii 0 bbbbb", lambda f: ok(f["d"]) and f["b"] >= f["i"])

# Data processing of registers (A5.3.11 to A5.3.15).
add("R", "PKHBT", "1110101 0110 0 nnnn 0 iii dddd ii 00 mmmm", lambda f: ok(f["d"], f["n"], f["m"]))
add("R", "PKHTB", "1110101 0110 0 nnnn 0 iii dddd ii 10 mmmm", lambda f: ok(f["d"], f["n"], f["m"]))
three = lambda f: ok(f["d"], f["n"], f["m"])
for op, name in enumerate("LSL LSR ASR ROR".split()):
    add("R", f"{name} reg", f"11111010 0 {op:02b} s nnnn 1111 dddd 0000 mmmm", three)
for op, name in enumerate("SXTH UXTH SXTB16 UXTB16 SXTB UXTB".split()):
    add("R", f"{name} 32", f"11111010 0 {op:03b} 1111 1111 dddd 10 rr mmmm", lambda f: ok(f["d"], f["m"]))
    add("R", f"{name} add", f"11111010 0 {op:03b} nnnn 1111 dddd 10 rr mmmm", three)
for op, name in ((1, "ADD16"), (2, "ASX"), (6, "SAX"), (5, "SUB16"), (0, "ADD8"), (4, "SUB8")):
    for prefix, treatment in (("S", 0b000), ("Q", 0b001), ("SH", 0b010), ("U", 0b100), ("UQ", 0b101), ("UH", 0b110)):
        add("R", f"{prefix}{name}", f"11111010 1 {op:03b} nnnn 1111 dddd 0 {treatment:03b} mmmm", three)
for op, name in enumerate("QADD QDADD QSUB QDSUB".split()):
    add("R", name, f"11111010 1000 nnnn 1111 dddd 10 {op:02b} mmmm", three)
for op, name in enumerate("REV REV16 RBIT REVSH".split()):
    add("R", f"{name} 32", f"11111010 1001 nnnn 1111 dddd 10 {op:02b} mmmm", lambda f: ok(f["d"], f["m"]) and f["m"] == f["n"])
add("R", "SEL", "11111010 1010 nnnn 1111 dddd 1000 mmmm", three)
add("R", "CLZ", "11111010 1011 nnnn 1111 dddd 1000 mmmm", lambda f: ok(f["d"], f["m"]) and f["m"] == f["n"])

# Multiplies (A5.3.16, A5.3.17).
four = lambda f: ok(f["d"], f["n"], f["m"], f["a"])
add("R", "MUL", "111110110 000 nnnn 1111 dddd 0000 mmmm", three)
add("R", "MLA", "111110110 000 nnnn aaaa dddd 0000 mmmm", four)
add("R", "MLS", "111110110 000 nnnn aaaa dddd 0001 mmmm", four)
for op, bits, name in ((1, "00xx", "SMLAxy"), (2, "000x", "SMLAD"), (3, "000x", "SMLAWy"), (4, "000x", "SMLSD"), (5, "000x", "SMMLA"), (7, "0000", "USADA8")):
    add("R", name, f"111110110 {op:03b} nnnn aaaa dddd {bits} mmmm", four)
    add("R", f"{name} alone", f"111110110 {op:03b} nnnn 1111 dddd {bits} mmmm", three)
add("R", "SMMLS", "111110110 110 nnnn aaaa dddd 000x mmmm", four)
long = lambda f: ok(f["d"], f["n"], f["m"], f["l"]) and f["d"] != f["l"]
for op, bits, name in ((0, "0000", "SMULL"), (2, "0000", "UMULL"), (4, "0000", "SMLAL"), (4, "10xx", "SMLALxy"), (4, "110x", "SMLALD"), (5, "110x", "SMLSLD"), (6, "0000", "UMLAL"), (6, "0110", "UMAAL")):
    add("R", name, f"111110111 {op:03b} nnnn llll dddd {bits} mmmm", long)
add("R", "SDIV", "111110111 001 nnnn 1111 dddd 1111 mmmm", three)
add("R", "UDIV", "111110111 011 nnnn 1111 dddd 1111 mmmm", three)

# Loads and stores (A5.3.5 to A5.3.10).
def base(f):
    return ok(f["t"], f["n"]) and f["t"] != f["n"]


for size, letter in ((0, "B"), (1, "H"), (2, "")):
    forms = [("STR" + letter, "0", "0"), ("LDR" + letter, "0", "1")] + ([("LDRS" + letter, "1", "1")] if letter else [])
    for name, sign, load in forms:
        head = f"1111100 {sign}"
        add("M", f"{name} imm12", f"{head} 1 {size:02b} {load} nnnn tttt 000iiiiiiiii", base)
        add("M", f"{name} imm8", f"{head} 0 {size:02b} {load} nnnn tttt 1 100 iiiiiiii", base)
        add("M", f"{name} pre", f"{head} 0 {size:02b} {load} nnnn tttt 1 1x1 iiiiiiii", base)
        add("M", f"{name} post", f"{head} 0 {size:02b} {load} nnnn tttt 1 0x1 iiiiiiii", base)
        add("M", f"{name} reg", f"{head} 0 {size:02b} {load} nnnn tttt 0 00000 kk mmmm", lambda f: base(f) and ok(f["m"]) and f["m"] != f["n"])
        if load == "1":
            add("L", f"{name} literal", f"{head} 1 {size:02b} 1 1111 tttt 000iiiiiiiii", lambda f: ok(f["t"]))
            add("L", f"{name} literal before", f"{head} 0 {size:02b} 1 1111 tttt 000iiiiiiiii", lambda f: ok(f["t"]))
        add("M", f"{name} unprivileged", f"{head} 0 {size:02b} {load} nnnn tttt 1 110 iiiiiiii", base)
for head in ("11111000 1001", "11111001 1001", "11111000 1011", "11111001 1011"):
    add("M", f"memory hint {head}", f"{head} nnnn 1111 iiiiiiiiiiii", lambda f: ok(f["n"]))
add("M", "PLD reg", "11111000 0001 nnnn 1111 000000 kk mmmm", lambda f: ok(f["n"], f["m"]) and f["m"] != f["n"])
add("D", "LDREX", "11101000 0101 nnnn tttt 1111 iiiiiiii", lambda f: ok(f["t"], f["n"]))
add("D", "LDREXB", "11101000 1101 nnnn tttt 1111 0100 1111", lambda f: ok(f["t"], f["n"]))
add("D", "LDREXH", "11101000 1101 nnnn tttt 1111 0101 1111", lambda f: ok(f["t"], f["n"]))
add("L", "LDRD literal", "11101001 x101 1111 tttt uuuu 0iiiiiii", lambda f: ok(f["t"], f["u"]) and f["t"] != f["u"])
dual = lambda f: ok(f["t"], f["u"], f["n"]) and f["t"] != f["u"] and f["n"] not in (f["t"], f["u"])
for load, name in ((0, "STRD"), (1, "LDRD")):
    add("D", f"{name} offset", f"1110100 1 x 1 0 {load} nnnn tttt uuuu iiiiiiii", dual)
    add("D", f"{name} pre", f"1110100 1 x 1 1 {load} nnnn tttt uuuu iiiiiiii", dual)
    add("D", f"{name} post", f"1110100 0 x 1 1 {load} nnnn tttt uuuu iiiiiiii", dual)
multiple = lambda f: f["n"] not in (13, 15) and bin(f["r"]).count("1") > 1 and not f["r"] >> f["n"] & 1
add("D", "STMIA", "1110100 01 0 w 0 nnnn 0 r 0 rrrrrrrrrrrrr", lambda f: multiple(lists(f)))
add("D", "STMDB", "1110100 10 0 w 0 nnnn 0 r 0 rrrrrrrrrrrrr", lambda f: multiple(lists(f)))
add("D", "LDMIA", "1110100 01 0 w 1 nnnn 0 r 0 rrrrrrrrrrrrr", lambda f: multiple(lists(f)))
add("D", "LDMDB", "1110100 10 0 w 1 nnnn 0 r 0 rrrrrrrrrrrrr", lambda f: multiple(lists(f)))


def lists(f):
    """The list with LR, whose bit stands apart, at its place."""
    return {"n": f["n"], "r": f["r"] & 0x1FFF | (f["r"] >> 13) << 14}


# Loads to PC. Only those that load the address of Thumb code become vectors.
add("B", "LDR pc imm12", "11111000 1101 nnnn 1111 000iiiiiii00", lambda f: ok(f["n"]))
add("B", "LDR pc imm8", "11111000 0101 nnnn 1111 1 100 iiiiii00", lambda f: ok(f["n"]))
add("B", "LDR pc pre", "11111000 0101 nnnn 1111 1 1x1 iiiiii00", lambda f: ok(f["n"]))
add("B", "LDR pc post", "11111000 0101 nnnn 1111 1 0x1 iiiiiiii", lambda f: ok(f["n"]))
add("B", "LDR pc reg", "11111000 0101 nnnn 1111 0 00000 10 mmmm", lambda f: ok(f["n"], f["m"]) and f["m"] != f["n"])
add("B", "LDR pc literal", "11111000 x101 1111 1111 000iiiiiii00")
add("B", "POP pc", "1011110 1 rrrrrrrr")
add("B", "LDMIA pc", "1110100 01 0 w 1 nnnn 10 rrrrrrrrrrrrrr", lambda f: ok(f["n"]) and f["r"] & 0x3FFF and not f["r"] >> f["n"] & 1 and not f["r"] >> 13)
add("B", "LDMDB pc", "1110100 10 0 w 1 nnnn 10 rrrrrrrrrrrrrr", lambda f: ok(f["n"]) and f["r"] & 0x3FFF and not f["r"] >> f["n"] & 1 and not f["r"] >> 13)


# Branches and control (A5.3.4, A5.3.6).
add("R", "B cond 32", "11110 i cccc iiiiii 10 i 0 i iiiiiiiiiii", lambda f: f["c"] < 14)
add("R", "B 32", "11110 iiiiiiiiiii 10 i 1 i iiiiiiiiiii")
add("R", "BL", "11110 iiiiiiiiiii 11 i 1 i iiiiiiiiiii")
add("R", "MRS apsr", "11110011 1110 1111 1000 dddd 000000xx", lambda f: ok(f["d"]))
add("R", "MSR apsr", "11110011 1000 nnnn 1000 kk00 000000xx", lambda f: ok(f["n"]) and f["k"] != 0)
add("M", "TBB", "11101000 1101 nnnn 11110000 0000 mmmm", lambda f: ok(f["n"], f["m"]) and f["m"] != f["n"])
add("M", "TBH", "11101000 1101 nnnn 11110000 0001 mmmm", lambda f: ok(f["n"], f["m"]) and f["m"] != f["n"])
add("R", "BX", "01000111 0 mmmm 000", lambda f: ok(f["m"]))
add("R", "BLX", "01000111 1 mmmm 000", lambda f: ok(f["m"]))
add("R", "DBG", "11110011 1010 1111 1000 0000 1111 iiii")
add("R", "CLREX", "11110011 1011 1111 1000 1111 0010 1111")
add("R", "DMB", "11110011 1011 1111 1000 1111 0101 iiii")
add("R", "ISB", "11110011 1011 1111 1000 1111 0110 iiii")
add("R", "NOP 32", "11110011 1010 1111 1000 0000 00000000")
add("R", "DSB", "11110011 1011 1111 1000 1111 0100 iiii")

# FPU (A6).
for bits, name in (("0x00", "VMLA"), ("0x01", "VNML"), ("0x10", "VMUL"), ("0x11", "VADD"), ("1x01", "VFNM"), ("1x10", "VFMA")):
    add("F", name, f"11101110 {bits} nnnn dddd 1010 x y x 0 mmmm")
add("F", "VDIV", "11101110 1x00 nnnn dddd 1010 x 0 x 0 mmmm")
add("F", "VMOV imm", "11101110 1x11 iiii dddd 1010 0000 iiii")
for opc, name in ((0b00000, "VMOV"), (0b00001, "VABS"), (0b00010, "VNEG"), (0b00011, "VSQRT"), (0b00100, "VCVTB from half"), (0b00101, "VCVTT from half"), (0b00110, "VCVTB to half"), (0b00111, "VCVTT to half"), (0b01000, "VCMP"), (0b01001, "VCMPE"), (0b10000, "VCVT from unsigned"), (0b10001, "VCVT from signed"), (0b11000, "VCVTR to unsigned"), (0b11001, "VCVT to unsigned"), (0b11010, "VCVTR to signed"), (0b11011, "VCVT to signed")):
    add("F", name, f"11101110 1x11 {opc >> 1:04b} dddd 1010 {opc & 1} 1 x 0 mmmm")
add("F", "VCMP zero", "11101110 1x11 0101 dddd 1010 y 1 0 0 0000")
# From fixed point rounds to nearest in every mode (A7.7, VCVT). Unicorn rounds as FPSCR says, so kind N keeps FPSCR.RMode zero.
for opc in (0b1010, 0b1011, 0b1110, 0b1111):
    direction = "to" if opc & 4 else "from"
    kind = "F" if opc & 4 else "N"
    add(kind, f"VCVT {direction} fixed 16, {opc & 1}", f"11101110 1x11 {opc:04b} dddd 1010 0 1 b 0 aaaa", lambda f: f["a"] * 2 + f["b"] <= 16)
    add(kind, f"VCVT {direction} fixed 32, {opc & 1}", f"11101110 1x11 {opc:04b} dddd 1010 1 1 b 0 aaaa")
add("F", "VMOV to core", "11101110 0001 nnnn tttt 1010 x 001 0000", lambda f: ok(f["t"]))
add("F", "VMOV to fpu", "11101110 0000 nnnn tttt 1010 x 001 0000", lambda f: ok(f["t"]))
add("F", "VMOV half to core", "11101110 00x1 nnnn tttt 1011 0001 0000", lambda f: ok(f["t"]))
add("F", "VMOV half to fpu", "11101110 00x0 nnnn tttt 1011 0001 0000", lambda f: ok(f["t"]))
add("F", "VMOV pair", "11101100 010 y uuuu tttt 1010 00 b 1 mmmm", lambda f: ok(f["t"], f["u"]) and f["t"] != f["u"] and f["m"] * 2 + f["b"] != 31)
add("F", "VMOV double", "11101100 010 y uuuu tttt 1011 0001 mmmm", lambda f: ok(f["t"], f["u"]) and f["t"] != f["u"])
add("F", "VMRS", "11101110 1111 0001 tttt 1010 0001 0000", lambda f: f["t"] != 13)
add("F", "VMSR", "11101110 1110 0001 tttt 1010 0001 0000", lambda f: ok(f["t"]))
fpbase = lambda f: f["n"] not in (13, 15)
for load, name in ((0, "VSTR"), (1, "VLDR")):
    add("D", name, f"11101101 yx0{load} nnnn dddd 1010 iiiiiiii", fpbase)
    add("D", f"{name} double", f"11101101 y00{load} nnnn dddd 1011 iiiiiiii", fpbase)
add("L", "VLDR literal", "11101101 yx01 1111 dddd 1010 iiiiiiii")
add("L", "VLDR literal double", "11101101 y001 1111 dddd 1011 iiiiiiii")
for load, name in ((0, "VSTM"), (1, "VLDM")):
    fits = lambda f: fpbase(f) and 0 < f["i"] and f["d"] * 2 + f["b"] + f["i"] <= 32
    add("D", name, f"11101100 1bw{load} nnnn dddd 1010 iiiiiiii", fits)
    add("D", f"{name} before", f"11101101 0b1{load} nnnn dddd 1010 iiiiiiii", fits)
    pairs = lambda f: fpbase(f) and 0 < f["i"] and f["i"] % 2 == 0 and f["d"] * 2 + f["i"] <= 32
    add("D", f"{name} double", f"11101100 10w{load} nnnn dddd 1011 iiiiiiii", pairs)
