"""Parameters of slave 2 in its flash, by the canopen package; master is this script."""

import unittest

from canopen.sdo import SdoAbortedError

from spacecraft import PRE_OPERATIONAL, Test

HEARTBEAT = 0x1017
STORE, RESTORE = 0x1010, 0x1011
#: The profile's, in milliseconds.
DEFAULT = 250


class Storing(Test):
    def setUp(self) -> None:
        self.net = self.connect(is_master=True)
        (self.slave,) = self.nodes(self.net, 2)
        self.remote = self.slave.remote
        self.remote.nmt.state = "PRE-OPERATIONAL"
        self.slave.becomes(PRE_OPERATIONAL)
        self.addCleanup(self.remote.restore)

    def heartbeat_after(self, reset: str) -> int:
        self.slave.states.forget()
        self.remote.nmt.state = reset
        self.slave.boots()
        return self.remote.sdo[HEARTBEAT].raw

    def test_what_is_stored_survives_a_reset_until_it_is_restored(self) -> None:
        self.remote.sdo[HEARTBEAT].raw = 444
        self.remote.store()
        for reset in ("RESET", "RESET COMMUNICATION"):
            self.assertEqual(self.heartbeat_after(reset), 444, reset)
        self.remote.restore()
        self.assertEqual(self.remote.sdo[HEARTBEAT].raw, 444, "it takes effect with the next reset")
        self.assertEqual(self.heartbeat_after("RESET"), DEFAULT)

    def test_what_is_not_stored_is_lost(self) -> None:
        self.remote.sdo[HEARTBEAT].raw = 333
        self.assertEqual(self.heartbeat_after("RESET"), DEFAULT)

    def test_a_wrong_signature_is_refused(self) -> None:
        """CiA 301 7.5.2.13, 7.5.2.14: abort code 0800002xh."""
        for index in (STORE, RESTORE):
            with self.assertRaises(SdoAbortedError) as refusal:
                self.remote.sdo[index][1].raw = 0x12345678
            self.assertEqual(refusal.exception.code >> 4, 0x0800002, str(refusal.exception))


if __name__ == "__main__":
    unittest.main(verbosity=2)
