"""Slaves 2 and 3 without a master, which the canopen package is: module control by node 1."""

import unittest

from spacecraft import BOOT_UP, OPERATIONAL, PRE_OPERATIONAL, STOPPED, Test

STARTUP = 0x1F80
#: Its values for a slave: bit 2 keeps it in Pre-operational.
BY_ITSELF, ON_COMMAND = 0, 4


class Nmt(Test):
    def setUp(self) -> None:
        self.net = self.connect(is_master=True)
        self.one, self.other = self.nodes(self.net, 2, 3)
        self.net.nmt.state = "PRE-OPERATIONAL"
        for node in (self.one, self.other):
            node.becomes(PRE_OPERATIONAL)

    def test_every_state_is_reached_from_every_other_one(self) -> None:
        names = {"OPERATIONAL": OPERATIONAL, "STOPPED": STOPPED, "PRE-OPERATIONAL": PRE_OPERATIONAL}
        path = ["OPERATIONAL", "STOPPED", "OPERATIONAL", "PRE-OPERATIONAL", "STOPPED", "PRE-OPERATIONAL"]
        for name in path:
            self.one.remote.nmt.state = name
            self.one.becomes(names[name], times=2)
            self.assertEqual(self.one.remote.nmt.state, name)
        self.other.becomes(PRE_OPERATIONAL)

    def test_node_0_is_everybody(self) -> None:
        self.net.nmt.state = "OPERATIONAL"
        for node in (self.one, self.other):
            node.becomes(OPERATIONAL)

    def test_both_resets_end_with_a_boot_up_message(self) -> None:
        for reset in ("RESET", "RESET COMMUNICATION"):
            self.one.remote.nmt.state = "OPERATIONAL"
            self.one.becomes(OPERATIONAL)
            self.one.states.forget()
            self.one.remote.nmt.state = reset
            self.one.boots()
            self.one.becomes(PRE_OPERATIONAL)
        self.other.becomes(PRE_OPERATIONAL)

    def test_nmt_startup_says_whether_a_slave_waits_to_be_started(self) -> None:
        """1F80h, bit 2; a reset of communication takes what is stored."""
        remote = self.one.remote
        self.addCleanup(remote.restore)
        remote.sdo[STARTUP].raw = BY_ITSELF
        remote.store()
        self.restarts(OPERATIONAL)
        self.assertEqual(remote.sdo[STARTUP].raw, BY_ITSELF)
        remote.restore()
        self.restarts(PRE_OPERATIONAL)
        self.assertEqual(remote.sdo[STARTUP].raw, ON_COMMAND)
        self.other.becomes(PRE_OPERATIONAL)

    def restarts(self, state: int) -> None:
        """Nobody starts it after its reset: this is the first state that it tells."""
        self.one.states.forget()
        self.one.remote.nmt.state = "RESET COMMUNICATION"
        told = self.one.states.wait_for(lambda told: BOOT_UP in told[:-2])
        after = told[told.index(BOOT_UP) + 1 :]
        self.assertEqual(set(after), {state})

    def test_malformed_commands_change_nothing(self) -> None:
        self.net.nmt.state = "OPERATIONAL"
        self.one.becomes(OPERATIONAL)
        self.one.states.forget()
        for data in ([], [0x80], [0x80, 2, 0], [0x83, 2], [0x00, 2], [0x80, 128], [0x80, 3]):
            self.net.send_message(0x000, data)
        # The last one was for node 3 alone.
        self.other.becomes(PRE_OPERATIONAL)
        states = self.one.states.wait_for(lambda told: len(told) >= 3)
        self.assertEqual(set(states), {OPERATIONAL})


if __name__ == "__main__":
    unittest.main(verbosity=2)
