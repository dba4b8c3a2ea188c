"""Slaves 2 and 3 without a master, which the canopen package is: module control by node 1."""

import unittest

from spacecraft import OPERATIONAL, PRE_OPERATIONAL, STOPPED, Test


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
