"""Cases of SYNC and of PDOs. An RPDO and a TPDO carry 6400h sub 5, one byte, under identifiers of their own."""

from conformance_bench import (
    EMCY,
    HEARTBEAT,
    INCOMPATIBLE,
    NODE,
    NOT_MAPPABLE,
    NO_OBJECT,
    NO_SUB,
    PDO_LENGTH,
    RANGE,
    REQUEST,
    START,
    SYNC,
    UNSUPPORTED,
    WRONG_STATE,
    Bench,
    byte,
    case,
)
from conformance_devices import DEVICE
from spacecraft import OPERATIONAL

RPDO, TPDO = DEVICE.rpdo, DEVICE.tpdo
#: From parameters to their mapping.
MAPPING = 0x200
RECEIVED, SENT = 0x1C2, 0x1C3
INVALID, NO_REMOTE, PRODUCER = 1 << 31, 1 << 30, 1 << 30
SAMPLE, SECOND, DUMMY, WIDE = 0x6400_05_08, 0x6400_06_10, 0x0005_00_08, 0x6400_1B_40
KINDS = {"RPDO": (RPDO, RECEIVED), "TPDO": (TPDO, SENT)}


def declare(bench: Bench, parameters: int, identifier: int, transmission: int, *mapped: int, **subs: int) -> None:
    """A PDO by the procedure of CiA 301 7.5.2.36; `sub3`, `sub5`, `sub6`: other parameters."""
    bench.write(parameters, 1, INVALID | NO_REMOTE | identifier, 4)
    bench.write(parameters + MAPPING, 0, 0, 1)
    for number, entry in enumerate(mapped, 1):
        bench.write(parameters + MAPPING, number, entry, 4)
    bench.write(parameters + MAPPING, 0, len(mapped), 1)
    bench.write(parameters, 2, transmission, 1)
    for name, value in subs.items():
        bench.write(parameters, int(name[3:]), value, 1 if name == "sub6" else 2)
    bench.write(parameters, 1, NO_REMOTE | identifier, 4)


def start(bench: Bench) -> None:
    bench.nmt(START)
    bench.wait_for(HEARTBEAT, bytes([OPERATIONAL]))
    bench.forget()


def sample(bench: Bench) -> int:
    return bench.read(0x6400, 5)


def set_sample(bench: Bench, value: int) -> None:
    bench.write(0x6400, 5, value, 1)


def change_sample(bench: Bench, value: int) -> None:
    """Its PDO may come before the response."""
    bench.send(REQUEST, bench.download(0x6400, 5, value, 1))


# SYNC.


@case("SYNC: one without data is no error")
def plain(bench: Bench) -> None:
    bench.send(SYNC)
    bench.hears_nothing(EMCY)


@case("SYNC: a slave does not produce it", byte(0, 0x60))
def no_producer(bench: Bench) -> None:
    bench.refuses_write(0x1005, 0, PRODUCER | SYNC, 4, RANGE)


@case("SYNC: 29 bits are refused", byte(0, 0x60))
def extended_sync(bench: Bench) -> None:
    bench.refuses_write(0x1005, 0, 1 << 29 | SYNC, 4, RANGE)


@case("SYNC: another identifier is obeyed, the old one is not")
def other_identifier(bench: Bench) -> None:
    bench.synchronize()
    bench.write(0x1005, 0, 0x0C0, 4)
    start(bench)
    bench.send(SYNC)
    bench.hears_nothing(0x180 + NODE)
    bench.send(0x0C0)
    bench.wait_for(0x180 + NODE)


for counter in (1, 241, 255):

    def reserved_counter(bench: Bench, counter=counter) -> None:
        bench.refuses_write(0x1019, 0, counter, 1, RANGE)

    case(f"SYNC: a counter of {counter} is refused", byte(0, 0x60))(reserved_counter)

for counter in (0, 2, 240):

    def possible_counter(bench: Bench, counter=counter) -> None:
        bench.write(0x1019, 0, counter, 1)
        assert bench.read(0x1019) == counter

    case(f"SYNC: a counter of {counter} is taken", byte(0, 0x80))(possible_counter)


@case("SYNC: its counter changes only without a period", byte(0, 0x60))
def counter_while_running(bench: Bench) -> None:
    bench.write(0x1006, 0, 1_000_000, 4)
    bench.refuses_write(0x1019, 0, 10, 1, WRONG_STATE)
    bench.write(0x1006, 0, 0, 4)
    bench.write(0x1019, 0, 10, 1)


@case("SYNC: with a counter, one without is 8240h", byte(0, 0x41, EMCY))
def counter_missing(bench: Bench) -> None:
    bench.write(0x1006, 0, 0, 4)
    bench.write(0x1019, 0, 10, 1)
    bench.send(SYNC, [1])
    bench.hears_nothing(EMCY)
    bench.send(SYNC)
    assert bench.wait_for(EMCY)[:2] == bytes([0x40, 0x82])


# Parameters.

for kind, (parameters, identifier) in KINDS.items():

    def types(bench: Bench, parameters=parameters) -> None:
        for transmission in (*range(241, 252), 252, 253):
            bench.refuses_write(parameters, 2, transmission, 1, RANGE)

    case(f"PDO: types 241 to 253 are refused in a {kind}", byte(0, 0x60))(types)

    def possible_types(bench: Bench, parameters=parameters) -> None:
        for transmission in (*range(241), 254, 255):
            bench.write(parameters, 2, transmission, 1)
            assert bench.read(parameters, 2) == transmission

    case(f"PDO: types 0 to 240, 254 and 255 are taken by a {kind}", byte(0, 0x80))(possible_types)

    def valid_identifier(bench: Bench, parameters=parameters, identifier=identifier) -> None:
        declare(bench, parameters, identifier, 254, SAMPLE)
        bench.refuses_write(parameters, 1, NO_REMOTE | identifier + 0x10, 4, UNSUPPORTED)
        # The write that makes it invalid may move it.
        bench.write(parameters, 1, INVALID | NO_REMOTE | identifier + 0x10, 4)

    case(f"PDO: a valid {kind} keeps its identifier", byte(0, 0x60))(valid_identifier)

    def valid_mapping(bench: Bench, parameters=parameters, identifier=identifier) -> None:
        declare(bench, parameters, identifier, 254, SAMPLE)
        bench.refuses_write(parameters + MAPPING, 0, 0, 1, UNSUPPORTED)
        bench.refuses_write(parameters + MAPPING, 1, SECOND, 4, UNSUPPORTED)

    case(f"PDO: a valid {kind} keeps its mapping", byte(0, 0x60))(valid_mapping)

    def entries_in_use(bench: Bench, parameters=parameters, identifier=identifier) -> None:
        bench.write(parameters + MAPPING, 0, 0, 1)
        bench.write(parameters + MAPPING, 1, SAMPLE, 4)
        bench.write(parameters + MAPPING, 0, 1, 1)
        bench.refuses_write(parameters + MAPPING, 1, SECOND, 4, UNSUPPORTED)

    case(f"PDO: entries of a {kind} change only while sub 0 is 0", byte(0, 0x60))(entries_in_use)

    for entry, code, words in (
        (0x1000_00_20, NOT_MAPPABLE, "that cannot be mapped"),
        (0x5FFF_00_08, NO_OBJECT, "that does not exist"),
        (0x1018_05_20, NO_SUB, "without this sub-index"),
        (0x6400_05_10, NOT_MAPPABLE, "of another length"),
    ):

        def wrong_entry(bench: Bench, parameters=parameters, entry=entry, code=code) -> None:
            bench.write(parameters + MAPPING, 0, 0, 1)
            bench.refuses_write(parameters + MAPPING, 1, entry, 4, code)

        case(f"PDO: an object {words} is refused in a {kind}", byte(0, 0x60))(wrong_entry)

    def too_long(bench: Bench, parameters=parameters) -> None:
        bench.write(parameters + MAPPING, 0, 0, 1)
        bench.write(parameters + MAPPING, 1, WIDE, 4)
        bench.write(parameters + MAPPING, 2, SAMPLE, 4)
        bench.refuses_write(parameters + MAPPING, 0, 2, 1, PDO_LENGTH)
        bench.write(parameters + MAPPING, 0, 1, 1)

    case(f"PDO: 72 bits are too many for a {kind}", byte(0, 0x60))(too_long)

    def too_many(bench: Bench, parameters=parameters) -> None:
        bench.write(parameters + MAPPING, 0, 0, 1)
        bench.refuses_write(parameters + MAPPING, 0, 9, 1, PDO_LENGTH)

    case(f"PDO: nine objects are too many for a {kind}", byte(0, 0x60))(too_many)

    def carries_nothing(bench: Bench, parameters=parameters, identifier=identifier) -> None:
        bench.write(parameters + MAPPING, 0, 0, 1)
        bench.refuses_write(parameters, 1, NO_REMOTE | identifier, 4, INCOMPATIBLE)

    case(f"PDO: a {kind} that carries nothing does not become valid", byte(0, 0x60))(carries_nothing)

    def no_sub(bench: Bench, parameters=parameters) -> None:
        bench.refuses_write(parameters, 7, 0, 1, NO_SUB)

    case(f"PDO: a {kind} has no sub 7", byte(0, 0x60))(no_sub)


@case("PDO: a TPDO allows no remote frames", byte(0, 0x60))
def remote(bench: Bench) -> None:
    bench.write(TPDO + MAPPING, 0, 0, 1)
    bench.write(TPDO + MAPPING, 1, SAMPLE, 4)
    bench.write(TPDO + MAPPING, 0, 1, 1)
    bench.refuses_write(TPDO, 1, SENT, 4, RANGE)


@case("PDO: the inhibit time of a valid TPDO stays", byte(0, 0x60))
def inhibit_time(bench: Bench) -> None:
    declare(bench, TPDO, SENT, 254, SAMPLE)
    bench.refuses_write(TPDO, 3, 100, 2, UNSUPPORTED)


@case("PDO: the SYNC start value of a valid TPDO stays", byte(0, 0x60))
def start_value(bench: Bench) -> None:
    declare(bench, TPDO, SENT, 1, SAMPLE)
    bench.refuses_write(TPDO, 6, 1, 1, UNSUPPORTED)


# Transmission.


@case("PDO: an event makes a TPDO of type 254 go out", byte(0, 0x23, SENT))
def event(bench: Bench) -> None:
    declare(bench, TPDO, SENT, 254, SAMPLE)
    start(bench)
    change_sample(bench, 0x22)
    bench.hears(SENT, [0x22])


@case("PDO: a TPDO of type 255 does the same", byte(0, 0x24, SENT))
def profile_event(bench: Bench) -> None:
    declare(bench, TPDO, SENT, 255, SAMPLE)
    start(bench)
    change_sample(bench, 0x23)
    bench.hears(SENT, [0x23])


@case("PDO: a TPDO of type 1 goes out with every SYNC", byte(0, 0x34, SENT))
def every_sync(bench: Bench) -> None:
    set_sample(bench, 0x33)
    declare(bench, TPDO, SENT, 1, SAMPLE)
    start(bench)
    for _ in range(3):
        bench.send(SYNC)
        bench.hears(SENT, [0x33])


@case("PDO: a TPDO of type 3 goes out with every third SYNC")
def every_third_sync(bench: Bench) -> None:
    declare(bench, TPDO, SENT, 3, SAMPLE)
    start(bench)
    for _ in range(3):
        for _ in range(2):
            bench.send(SYNC)
            bench.hears_nothing(SENT)
        bench.send(SYNC)
        bench.wait_for(SENT)


@case("PDO: a TPDO of type 0 waits for an event and for SYNC", byte(0, 0x45, SENT))
def acyclic(bench: Bench) -> None:
    declare(bench, TPDO, SENT, 0, SAMPLE)
    start(bench)
    # An event before the first SYNC is that of the start, if it is one.
    bench.send(SYNC)
    bench.send(SYNC)
    bench.hears_nothing()
    bench.forget()
    bench.send(SYNC)
    bench.hears_nothing(SENT)
    change_sample(bench, 0x44)
    bench.hears_nothing(SENT)
    bench.send(SYNC)
    bench.hears(SENT, [0x44])


@case("PDO: an event timer makes a TPDO go out again and again")
def event_timer(bench: Bench) -> None:
    declare(bench, TPDO, SENT, 254, SAMPLE, sub5=50)
    start(bench)
    for _ in range(5):
        bench.wait_for(SENT)


@case("PDO: an inhibit time keeps TPDOs apart")
def inhibited(bench: Bench) -> None:
    # 3 s in units of 100 us.
    declare(bench, TPDO, SENT, 254, SAMPLE, sub3=30_000)
    start(bench)
    change_sample(bench, 1)
    bench.wait_for(SENT)
    change_sample(bench, 2)
    bench.hears_nothing(SENT, seconds=0.5)
    bench.hears(SENT, [2])


@case("PDO: a start value makes a TPDO count from that SYNC on")
def sync_start(bench: Bench) -> None:
    bench.write(0x1006, 0, 0, 4)
    bench.write(0x1019, 0, 10, 1)
    declare(bench, TPDO, SENT, 1, SAMPLE, sub6=3)
    start(bench)
    for counter in (1, 2):
        bench.send(SYNC, [counter])
        bench.hears_nothing(SENT)
    for counter in (3, 4):
        bench.send(SYNC, [counter])
        bench.wait_for(SENT)


@case("PDO: a TPDO that is not valid does not go out")
def invalid(bench: Bench) -> None:
    declare(bench, TPDO, SENT, 254, SAMPLE)
    bench.write(TPDO, 1, INVALID | NO_REMOTE | SENT, 4)
    start(bench)
    set_sample(bench, 7)
    bench.hears_nothing(SENT)


# Reception.


@case("PDO: an RPDO of type 254 takes effect at once", byte(4, 0x56))
def received(bench: Bench) -> None:
    declare(bench, RPDO, RECEIVED, 254, SAMPLE)
    start(bench)
    bench.send(RECEIVED, [0x55])
    assert sample(bench) == 0x55


@case("PDO: an RPDO of type 1 takes effect at the next SYNC", byte(4, 0x67))
def synchronous(bench: Bench) -> None:
    set_sample(bench, 0x11)
    declare(bench, RPDO, RECEIVED, 1, SAMPLE)
    start(bench)
    bench.send(RECEIVED, [0x66])
    assert sample(bench) == 0x11
    bench.send(SYNC)
    assert sample(bench) == 0x66


@case("PDO: of two synchronous ones the newest takes effect", byte(4, 0x77))
def newest(bench: Bench) -> None:
    declare(bench, RPDO, RECEIVED, 1, SAMPLE)
    start(bench)
    bench.send(RECEIVED, [0x67])
    bench.send(RECEIVED, [0x68])
    bench.send(SYNC)
    assert sample(bench) == 0x68


@case("PDO: an RPDO is taken in Operational alone", byte(4, 0x77))
def not_operational(bench: Bench) -> None:
    set_sample(bench, 0x12)
    declare(bench, RPDO, RECEIVED, 254, SAMPLE)
    bench.send(RECEIVED, [0x13])
    assert sample(bench) == 0x12


@case("PDO: one that is too long is processed, and 8220h", byte(0, 0x21, EMCY))
def long_pdo(bench: Bench) -> None:
    declare(bench, RPDO, RECEIVED, 254, SAMPLE)
    start(bench)
    bench.send(RECEIVED, [0x70, 1])
    assert bench.wait_for(EMCY)[:3] == bytes([0x20, 0x82, 0x11])
    assert sample(bench) == 0x70


@case("PDO: one that is too short is not processed, and 8210h", byte(0, 0x11, EMCY))
def short_pdo(bench: Bench) -> None:
    declare(bench, RPDO, RECEIVED, 254, SECOND)
    start(bench)
    bench.send(RECEIVED, [0x71])
    assert bench.wait_for(EMCY)[:3] == bytes([0x10, 0x82, 0x11])


@case("PDO: dummy entries of an RPDO are skipped", byte(4, 0x77))
def dummy(bench: Bench) -> None:
    declare(bench, RPDO, RECEIVED, 254, DUMMY, SAMPLE)
    start(bench)
    bench.send(RECEIVED, [0x01, 0x72])
    assert sample(bench) == 0x72


@case("PDO: a TPDO has no dummy entries", byte(0, 0x60))
def no_dummy(bench: Bench) -> None:
    bench.write(TPDO + MAPPING, 0, 0, 1)
    bench.refuses_write(TPDO + MAPPING, 1, DUMMY, 4, NOT_MAPPABLE)


@case("PDO: an RPDO that does not come in its time is 8250h", byte(0, 0x51, EMCY))
def overdue(bench: Bench) -> None:
    declare(bench, RPDO, RECEIVED, 254, SAMPLE, sub5=300)
    start(bench)
    bench.hears_nothing(EMCY, seconds=0.5)
    bench.send(RECEIVED, [1])
    assert bench.wait_for(EMCY)[:3] == bytes([0x50, 0x82, 0x11])
