"""Cases of module control, and of heartbeats: their producer, their consumer, what an error leads to."""

from conformance_bench import (
    EMCY,
    HEARTBEAT,
    NMT,
    NODE,
    PREPARE,
    REQUEST,
    RESET_COMMUNICATION,
    RESET_NODE,
    RESPONSE,
    RANGE,
    START,
    STOP,
    SYNC,
    Bench,
    byte,
    case,
)
from conformance_devices import DEVICE
from spacecraft import OPERATIONAL, PRE_OPERATIONAL, STOPPED

STATES = {PRE_OPERATIONAL: PREPARE, OPERATIONAL: START, STOPPED: STOP}
NAMES = {PRE_OPERATIONAL: "Pre-operational", OPERATIONAL: "Operational", STOPPED: "Stopped"}
COMMANDS = {START: "start", STOP: "stop", PREPARE: "enter Pre-operational"}
LEADS_TO = {START: OPERATIONAL, STOP: STOPPED, PREPARE: PRE_OPERATIONAL}

#: Another node that the slave consumes, its heartbeat, its entry of 1016h, and consumer times, milliseconds: a short one, and
#: one within which a script that is held up still sends a heartbeat.
OTHER, OTHERS, ENTRY, TIME, LONG = 9, 0x709, 2, 300, 3_000


def enter(bench: Bench, state: int) -> None:
    bench.nmt(STATES[state])
    bench.wait_for(HEARTBEAT, bytes([state]))


for before in STATES:
    for command, words in COMMANDS.items():

        def obeyed(bench: Bench, before=before, command=command) -> None:
            enter(bench, before)
            bench.forget()
            bench.nmt(command)
            bench.wait_for(HEARTBEAT, bytes([LEADS_TO[command]]))
            assert bench.state() == LEADS_TO[command]

        case(f"NMT: {words} in {NAMES[before]}", byte(0, 0x7E, HEARTBEAT))(obeyed)

    for reset, words in ((RESET_NODE, "reset node"), (RESET_COMMUNICATION, "reset communication")):

        def boots(bench: Bench, before=before, reset=reset) -> None:
            enter(bench, before)
            bench.forget()
            bench.nmt(reset)
            bench.wait_for(HEARTBEAT, bytes([0]))
            bench.wait_for(HEARTBEAT, bytes([PRE_OPERATIONAL]))

        case(f"NMT: {words} in {NAMES[before]} ends with the boot-up message", byte(0, 0x7E, HEARTBEAT))(boots)

    for data, words in (
        ([0x83, NODE], "an unknown command"),
        ([START], "a command without node"),
        ([START, NODE, 0], "a command of three bytes"),
        ([STOP, NODE + 1], "a command for another node"),
        ([STOP, 128], "a command for node 128"),
    ):

        def ignored(bench: Bench, before=before, data=data) -> None:
            enter(bench, before)
            bench.send(NMT, data)
            assert bench.state() == before
            assert bench.state() == before

        case(f"NMT: {words} changes nothing in {NAMES[before]}", byte(0, 0x7E, HEARTBEAT))(ignored)

    def everybody(bench: Bench, before=before) -> None:
        enter(bench, before)
        bench.nmt(START, 0)
        bench.wait_for(HEARTBEAT, bytes([OPERATIONAL]))

    case(f"NMT: node 0 is everybody, in {NAMES[before]}")(everybody)

    def answers(bench: Bench, before=before) -> None:
        enter(bench, before)
        bench.send(REQUEST, "40 18 10 04 00 00 00 00")
        if before == STOPPED:
            bench.hears_nothing(RESPONSE)
        else:
            bench.hears(RESPONSE, "43 18 10 04 03 00 00 00")

    case(f"NMT: SDO in {NAMES[before]}", None if before == STOPPED else byte(0, 0x42))(answers)

    def produces(bench: Bench, before=before) -> None:
        bench.synchronize()
        enter(bench, before)
        bench.forget()
        bench.send(SYNC)
        if before == OPERATIONAL:
            assert len(bench.wait_for(0x180 + NODE)) == DEVICE.telemetry
        else:
            bench.hears_nothing(0x180 + NODE)

    case(f"NMT: PDOs in {NAMES[before]}")(produces)

    def tells_errors(bench: Bench, before=before) -> None:
        """A SYNC that is too long is an error where there is SYNC."""
        enter(bench, before)
        bench.forget()
        bench.send(SYNC, [1])
        if before == STOPPED:
            bench.hears_nothing(EMCY)
        else:
            assert bench.wait_for(EMCY)[:2] == bytes([0x40, 0x82])

    case(f"NMT: EMCY in {NAMES[before]}")(tells_errors)


@case("heartbeat: its period is 1017h", byte(0, 0x7E, HEARTBEAT))
def period(bench: Bench) -> None:
    # A minute, which no test waits for, and a tenth of a second.
    bench.write(0x1017, 0, 60_000, 2)
    bench.wait_for(HEARTBEAT)
    bench.hears_nothing(HEARTBEAT, seconds=1.0)
    bench.write(0x1017, 0, 100, 2)
    for _ in range(5):
        bench.wait_for(HEARTBEAT, bytes([PRE_OPERATIONAL]))


@case("heartbeat: a period of 0 is none")
def no_period(bench: Bench) -> None:
    bench.write(0x1017, 0, 0, 2)
    bench.forget()
    bench.hears_nothing(HEARTBEAT, seconds=1.0)
    bench.write(0x1017, 0, 250, 2)
    bench.wait_for(HEARTBEAT)


def consume(bench: Bench, time: int = TIME) -> None:
    """Node 9 is consumed, and heard once."""
    bench.write(0x1016, ENTRY, OTHER << 16 | time, 4)
    bench.send(OTHERS, [OPERATIONAL])


@case("heartbeat: a consumer begins with the first heartbeat")
def unarmed(bench: Bench) -> None:
    bench.write(0x1016, ENTRY, OTHER << 16 | TIME, 4)
    bench.forget()
    bench.hears_nothing(EMCY, seconds=3 * TIME / 1000)


@case("heartbeat: one that is missed is EMCY 8130h, once", byte(0, 0x31, EMCY))
def missed(bench: Bench) -> None:
    consume(bench)
    bench.hears(EMCY, [0x30, 0x81, 0x11, OTHER, 0, 0, 0, 0])
    bench.hears_nothing(EMCY, seconds=3 * TIME / 1000)
    assert bench.read(0x1001) == 0x11


@case("heartbeat: the next one ends the error", byte(0, 0x01, EMCY))
def resolved(bench: Bench) -> None:
    consume(bench, LONG)
    bench.hears(EMCY, [0x30, 0x81, 0x11, OTHER, 0, 0, 0, 0])
    bench.send(OTHERS, [OPERATIONAL])
    bench.hears_end(0x8130)
    assert bench.read(0x1001) == 0


@case("heartbeat: one in time is no error")
def in_time(bench: Bench) -> None:
    consume(bench, LONG)
    bench.forget()
    for _ in range(6):
        bench.hears_nothing(EMCY, seconds=LONG / 5000)
        bench.send(OTHERS, [OPERATIONAL])


@case("heartbeat: an entry that is written with time 0 is not in use")
def unused(bench: Bench) -> None:
    consume(bench)
    bench.write(0x1016, ENTRY, OTHER << 16, 4)
    bench.forget()
    bench.hears_nothing(EMCY, seconds=3 * TIME / 1000)


@case("heartbeat: reserved bits of 1016h are refused", byte(4, 0x77))
def reserved(bench: Bench) -> None:
    bench.refuses_write(0x1016, ENTRY, 1 << 24 | OTHER << 16 | TIME, 4, RANGE)


for behaviour, state in ((0, PRE_OPERATIONAL), (1, OPERATIONAL), (2, STOPPED)):

    def behaves(bench: Bench, behaviour=behaviour, state=state) -> None:
        bench.write(0x1029, 1, behaviour, 1)
        enter(bench, OPERATIONAL)
        consume(bench)
        if state != OPERATIONAL:
            bench.wait_for(HEARTBEAT, bytes([state]))
        else:
            # A stopped node tells no error, all others do.
            bench.wait_for(EMCY)
        assert bench.state() == state

    case(f"heartbeat: error behaviour {behaviour} leads to {NAMES[state]}", byte(0, 0x7E, HEARTBEAT))(behaves)


@case("heartbeat: error behaviour 0 leaves a stopped node stopped")
def stays_stopped(bench: Bench) -> None:
    bench.write(0x1029, 1, 0, 1)
    consume(bench)
    enter(bench, STOPPED)
    bench.hears_nothing(EMCY, seconds=2 * TIME / 1000)
    assert bench.state() == STOPPED
