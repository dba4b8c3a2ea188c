"""Cases of emergencies and of identifiers."""

from conformance_bench import (
    EMCY,
    NO_DATA,
    RANGE,
    START,
    SYNC,
    Bench,
    byte,
    case,
)
from conformance_devices import DEVICE

#: SYNC with a counter that 1019h does not announce (CiA 301: 8240h), told with the bits of a communication error.
SYNC_LENGTH = bytes([0x40, 0x82, 0x11])
INVALID, FRAME_29_BITS, NO_REMOTE = 1 << 31, 1 << 29, 1 << 30
#: RPDO and TPDO that the device does not use.
UNUSED = {"RPDO": DEVICE.rpdo, "TPDO": DEVICE.tpdo}


def err(bench: Bench) -> bytes:
    """An error, and its end with the next SYNC."""
    bench.send(SYNC, [1])
    told = bench.wait_for(EMCY)
    assert told[:3] == SYNC_LENGTH, told.hex(" ")
    return told


@case("EMCY: code, register, five bytes", byte(2, 0x10, EMCY))
def layout(bench: Bench) -> None:
    assert len(err(bench)) == 8


@case("EMCY: an error is told once, and its end", byte(0, 0x01, EMCY))
def once(bench: Bench) -> None:
    err(bench)
    bench.send(SYNC, [1])
    bench.hears_nothing(EMCY)
    bench.send(SYNC)
    bench.hears_end(0x8240)


@case("EMCY: 1001h has bits 0 and 4 while there is a communication error", byte(4, 0x10))
def register(bench: Bench) -> None:
    assert bench.read(0x1001) == 0
    err(bench)
    assert bench.read(0x1001) == 0x11
    bench.send(SYNC)
    bench.wait_for(EMCY)
    assert bench.read(0x1001) == 0


@case("EMCY: 1003h keeps the newest first", byte(4, 0x09))
def history(bench: Bench) -> None:
    bench.write(0x1003, 0, 0, 1)
    err(bench)
    assert bench.read(0x1003, 0) == 1
    assert bench.read(0x1003, 1) & 0xFFFF == 0x8240
    bench.refuses("40 03 10 02", 0x1003, 2, NO_DATA)
    bench.nmt(START)
    bench.send(DEVICE.command, DEVICE.short)
    bench.wait_for(EMCY)
    assert bench.read(0x1003, 0) == 2
    assert [bench.read(0x1003, sub) & 0xFFFF for sub in (1, 2)] == [0x8210, 0x8240]


@case("EMCY: 0 to 1003h forgets the errors, another number is refused", byte(4, 0x09))
def forgotten(bench: Bench) -> None:
    err(bench)
    bench.refuses_write(0x1003, 0, 1, 1, RANGE)
    bench.write(0x1003, 0, 0, 1)
    assert bench.read(0x1003, 0) == 0
    bench.refuses("40 03 10 01", 0x1003, 1, NO_DATA)


@case("EMCY: 1014h keeps its identifier while it is valid", byte(4, 0x77))
def identifier(bench: Bench) -> None:
    assert bench.read(0x1014) & ~INVALID == EMCY
    bench.refuses_write(0x1014, 0, 0x84, 4, RANGE)
    bench.write(0x1014, 0, INVALID | EMCY, 4)
    bench.write(0x1014, 0, INVALID | 0x84, 4)
    bench.write(0x1014, 0, 0x84, 4)
    bench.send(SYNC, [1])
    assert bench.wait_for(0x84)[:3] == SYNC_LENGTH


@case("EMCY: none while 1014h is not valid")
def silent(bench: Bench) -> None:
    bench.write(0x1014, 0, INVALID | EMCY, 4)
    bench.send(SYNC, [1])
    bench.hears_nothing(EMCY)
    assert bench.read(0x1001) == 0x11


@case("EMCY: 29 bits are refused in 1014h", byte(4, 0x77))
def extended_emergency(bench: Bench) -> None:
    bench.write(0x1014, 0, INVALID | EMCY, 4)
    bench.refuses_write(0x1014, 0, FRAME_29_BITS | EMCY, 4, RANGE)


@case("EMCY: 1015h keeps messages apart")
def inhibited(bench: Bench) -> None:
    # 5 s in units of 100 us: by the clock on the wall it is far away.
    bench.write(0x1015, 0, 50_000, 2)
    err(bench)
    bench.send(SYNC)
    bench.hears_nothing(EMCY, seconds=0.5)
    bench.hears_end(0x8240)


@case("EMCY: a PDO that is too short is 8210h, and not processed", byte(0, 0x11, EMCY))
def short_pdo(bench: Bench) -> None:
    bench.nmt(START)
    bench.send(DEVICE.command, DEVICE.short)
    assert bench.wait_for(EMCY)[:3] == bytes([0x10, 0x82, 0x11])


@case("EMCY: a SYNC of wrong length is 8240h", byte(0, 0x41, EMCY))
def long_sync(bench: Bench) -> None:
    bench.send(SYNC, [1, 2])
    assert bench.wait_for(EMCY)[:3] == SYNC_LENGTH


#: CiA 301 7.3.5.
RESTRICTED = [
    (0x000, 0x07F),
    (0x101, 0x180),
    (0x581, 0x5FF),
    (0x601, 0x67F),
    (0x6E0, 0x6FF),
    (0x701, 0x77F),
    (0x780, 0x7FF),
]

for kind, parameters in UNUSED.items():
    for low, high in RESTRICTED:

        def restricted(bench: Bench, parameters=parameters, low=low, high=high) -> None:
            for number in range(low, high + 1):
                bench.refuses_write(parameters, 1, NO_REMOTE | number, 4, RANGE)

        case(f"identifiers: {low:03X}h to {high:03X}h are no {kind}'s", byte(0, 0x60))(restricted)

    def extended(bench: Bench, parameters=parameters) -> None:
        bench.refuses_write(parameters, 1, NO_REMOTE | FRAME_29_BITS | 0x1C2, 4, RANGE)

    case(f"identifiers: 29 bits are refused in a {kind}", byte(0, 0x60))(extended)

for low, high in RESTRICTED:

    def no_sync(bench: Bench, low=low, high=high) -> None:
        for number in {low, (low + high) // 2, high}:
            bench.refuses_write(0x1005, 0, number, 4, RANGE)

    case(f"identifiers: {low:03X}h to {high:03X}h are not SYNC's", byte(0, 0x60))(no_sync)

    def no_emergency(bench: Bench, low=low, high=high) -> None:
        bench.write(0x1014, 0, INVALID | EMCY, 4)
        for number in {low, (low + high) // 2, high}:
            bench.refuses_write(0x1014, 0, number, 4, RANGE)

    case(f"identifiers: {low:03X}h to {high:03X}h are not EMCY's", byte(0, 0x60))(no_emergency)
