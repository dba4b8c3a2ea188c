"""Slave 3 on the CAN driver of embassy-stm32, with the canopen package as its master: `firmware/examples/embassy-slave`."""

import struct
import unittest

from canopen.sdo import SdoAbortedError

from spacecraft import EDS, NOMINAL, OPERATIONAL, PATIENCE, PRE_OPERATIONAL, STOPPED, Channel, Observer, Test

NODE = 3
COMMAND, ANSWER, HEARTBEAT = 0x203, 0x183, 0x703
HEARTBEAT_TIME, POWER, TEMPERATURE = "Producer heartbeat time", "Power in percent", "Temperature"
NOTE = "Note of the operator"
TOO_HIGH = 0x06090031
READ_ONLY = 0x06010002


class Embassy(Test):
    def setUp(self) -> None:
        self.net = self.connect()
        self.node = self.net.add_node(NODE, str(EDS))
        self.sdo = self.node.sdo
        self.sdo.RESPONSE_TIMEOUT = PATIENCE
        self.states = Observer()
        self.node.nmt.add_heartbeat_callback(self.states)
        self.becomes(PRE_OPERATIONAL, "PRE-OPERATIONAL")

    def becomes(self, state: int, command: str) -> None:
        """Commands a state and waits for a heartbeat with it."""
        self.states.wait_for(bool)
        self.node.nmt.state = command
        self.states.forget()
        self.states.wait_for(lambda told: told[-1:] == [state])

    def test_every_state_is_reached(self) -> None:
        self.becomes(OPERATIONAL, "OPERATIONAL")
        self.becomes(STOPPED, "STOPPED")
        self.becomes(PRE_OPERATIONAL, "PRE-OPERATIONAL")

    def test_both_resets_end_with_a_boot_up_message(self) -> None:
        for reset in ("RESET", "RESET COMMUNICATION"):
            self.states.forget()
            self.node.nmt.state = reset
            self.states.wait_for(lambda told: 0 in told)

    def test_values_of_every_length_are_moved(self) -> None:
        note = "".join(chr(0x20 + at % 95) for at in range(200))
        self.sdo[NOTE].raw = note
        self.assertEqual(self.sdo[NOTE].raw, note)
        with self.sdo[NOTE].open("wb", size=200, block_transfer=True) as stream:
            stream.write(note[::-1].encode())
        with self.sdo[NOTE].open("rb", block_transfer=True) as stream:
            self.assertEqual(stream.read(), note[::-1].encode())
        self.sdo[POWER].raw = 7
        self.assertEqual((self.sdo[POWER].raw, self.sdo[TEMPERATURE].raw), (7, 207))

    def test_refusals_have_their_abort_codes(self) -> None:
        for name, value, code in ((POWER, 101, TOO_HIGH), (TEMPERATURE, 0, READ_ONLY)):
            with self.assertRaises(SdoAbortedError, msg=name) as refusal:
                self.sdo[name].raw = value
            self.assertEqual(refusal.exception.code, code)

    def test_a_command_by_pdo_is_answered_by_pdo(self) -> None:
        answers = Observer()
        self.net.subscribe(ANSWER, lambda _id, data, _at: answers(bytes(data)))
        self.becomes(OPERATIONAL, "OPERATIONAL")
        for power in (100, 0, 55):
            self.net.send_message(COMMAND, bytes([power]))
            answer = struct.pack("<h", 200 + power)
            answers.wait_for(lambda told: told[-1:] == [answer])

    def test_heartbeats_have_their_period(self) -> None:
        self.sdo[HEARTBEAT_TIME].raw = 50
        self.addCleanup(setattr, self.sdo[HEARTBEAT_TIME], "raw", 100)
        with Channel(NOMINAL) as channel:
            beats = [frame.ms for frame in channel.listen(1.0) if frame.id == HEARTBEAT]
        gaps = {later - earlier for earlier, later in zip(beats, beats[1:])}
        self.assertLessEqual(gaps, {49, 50, 51})
        self.assertGreaterEqual(len(beats), 19)


if __name__ == "__main__":
    unittest.main(verbosity=2)
