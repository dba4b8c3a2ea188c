"""Telecommands and telemetry requests as raw PDOs to slaves 2 and 3, whose master is this script."""

import struct
import unittest

from spacecraft import OPERATIONAL, PRE_OPERATIONAL, Node, Test, Observer

SET_VALUE, RESET_COUNTERS, UNKNOWN = 0x0002, 0x0003, 0x7777
UPTIME, VALUE, EXECUTED = 0x0101, 0x0102, 0x0103


class Telemetry(Test):
    def setUp(self) -> None:
        self.net = self.connect(is_master=True)
        self.slaves = self.nodes(self.net, 2, 3)
        self.net.nmt.state = "OPERATIONAL"
        for node in self.slaves:
            node.becomes(OPERATIONAL)

    def number(self, node: Node, code: int) -> int:
        return int.from_bytes(node.ask(code), "little")

    def test_a_value_that_is_set_is_read_back(self) -> None:
        one, other = self.slaves
        for number in (0, 1, 0xDEADBEEF, 0xFFFFFFFF):
            one.command(SET_VALUE, struct.pack("<I", number))
            other.command(SET_VALUE, struct.pack("<I", number ^ 0x55))
            self.assertEqual(self.number(one, VALUE), number)
            self.assertEqual(self.number(other, VALUE), number ^ 0x55)

    def test_commands_are_counted_and_unknown_ones_declined(self) -> None:
        node = self.slaves[0]
        node.command(RESET_COUNTERS)
        before = self.number(node, EXECUTED)
        for number in range(5):
            node.command(SET_VALUE, struct.pack("<I", number))
        node.command(UNKNOWN, b"\x01")
        self.assertEqual(self.number(node, EXECUTED), before + 5)

    def test_a_command_that_is_repeated_is_executed_once(self) -> None:
        """CAN delivers at least once: telemetry counts 1 executed, then 2 repeats."""
        node = self.slaves[0]
        node.command(RESET_COUNTERS)
        node.command(SET_VALUE, struct.pack("<I", 7))
        node.repeat(SET_VALUE, struct.pack("<I", 7))
        node.repeat(SET_VALUE, struct.pack("<I", 7))
        self.assertEqual(node.ask(EXECUTED), struct.pack("<IH", 1, 2))
        node.command(SET_VALUE, struct.pack("<I", 7))
        self.assertEqual(node.ask(EXECUTED), struct.pack("<IH", 2, 2))

    def test_a_request_may_be_its_code_alone(self) -> None:
        """ECSS Figure 9-2: DLC 0 to 8."""
        node = self.slaves[0]
        errors = Observer()
        node.remote.emcy.add_callback(lambda error: errors(error.code))
        node.command(SET_VALUE, struct.pack("<I", 0x1234))
        for zeros in range(7):
            self.assertEqual(node.ask(VALUE, zeros), struct.pack("<IH", 0x1234, 0))
        self.assertNotIn(0x8210, errors.wait_for(lambda _told: True))

    def test_uptime_grows(self) -> None:
        node = self.slaves[0]
        earlier = self.number(node, UPTIME)
        node.becomes(OPERATIONAL)
        self.assertGreater(self.number(node, UPTIME), earlier)

    def test_a_pdo_that_is_too_short_is_an_emergency(self) -> None:
        """CiA 301 7.2.7.1: 8210h, PDO not processed due to length error."""
        node = self.slaves[0]
        before = self.number(node, EXECUTED)
        errors = Observer()
        node.remote.emcy.add_callback(lambda error: errors(error.code))
        self.net.send_message(0x302, struct.pack("<HI", SET_VALUE, 1))
        errors.wait_for(lambda told: 0x8210 in told)
        self.assertEqual(node.remote.sdo[0x1003][1].raw & 0xFFFF, 0x8210)
        self.assertEqual(self.number(node, EXECUTED), before)

    def test_no_pdo_is_obeyed_before_operational(self) -> None:
        node = self.slaves[0]
        node.command(SET_VALUE, struct.pack("<I", 1))
        self.assertEqual(self.number(node, VALUE), 1)
        node.remote.nmt.state = "PRE-OPERATIONAL"
        node.becomes(PRE_OPERATIONAL)
        node.command(SET_VALUE, struct.pack("<I", 2))
        node.remote.nmt.state = "OPERATIONAL"
        node.becomes(OPERATIONAL)
        self.assertEqual(self.number(node, VALUE), 1)


if __name__ == "__main__":
    unittest.main(verbosity=2)
