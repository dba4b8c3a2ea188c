"""PDOs of slave 2, and of 3, a test device, by the canopen package, which learns their mapping from the slaves themselves;
master is this script.
"""

import unittest

from spacecraft import OPERATIONAL, PRE_OPERATIONAL, Test, Observer

SET_VALUE, VALUE = 0x0002, 0x0102
#: Numbers of the PDOs, from 1 on.
TELECOMMAND, REQUEST, TELEMETRY, SPARE = 2, 3, 3, 5


class Pdo(Test):
    def setUp(self) -> None:
        self.net = self.connect(is_master=True)
        self.use(2)

    def use(self, number: int) -> None:
        """This slave is meant from now on."""
        (self.slave,) = self.nodes(self.net, number)
        self.remote = self.slave.remote
        self.remote.nmt.state = "PRE-OPERATIONAL"
        self.slave.becomes(PRE_OPERATIONAL)
        self.remote.rpdo.read()
        self.remote.tpdo.read()

    def start(self) -> None:
        self.remote.nmt.state = "OPERATIONAL"
        self.slave.becomes(OPERATIONAL)

    def send(self, number: int, code: int, data: int, sequence: int = 0) -> None:
        pdo = self.remote.rpdo[number]
        pdo[0].raw, pdo[1].raw = code, data
        if number == TELECOMMAND:
            pdo[2].raw = sequence
        pdo.transmit()

    def test_the_mapping_is_that_of_the_mission(self) -> None:
        for pdos, number, cob_id, names in [
            (self.remote.rpdo, TELECOMMAND, 0x302, ["Telecommand.Code", "Telecommand.Data", "Telecommand.Sequence"]),
            (self.remote.rpdo, REQUEST, 0x402, ["Telemetry request.Code", "Telemetry request.Data"]),
            (self.remote.tpdo, TELEMETRY, 0x382, ["Telemetry.Code", "Telemetry.Data"]),
        ]:
            pdo = pdos[number]
            self.assertEqual((pdo.cob_id, pdo.enabled, pdo.rtr_allowed), (cob_id, True, False))
            self.assertEqual([variable.name for variable in pdo], names)
            self.assertEqual(sum(variable.length for variable in pdo), 64)

    def test_what_is_sent_is_executed_and_the_answer_subscribed(self) -> None:
        answers = Observer()
        self.remote.tpdo[TELEMETRY].add_callback(lambda pdo: answers((pdo[0].raw, pdo[1].raw)))
        self.start()
        for sequence, value in enumerate((0xC0FFEE, 0xFFFFFFFF, 0)):
            answers.forget()
            self.send(TELECOMMAND, SET_VALUE, value, sequence)
            self.send(REQUEST, VALUE, 0)
            answers.wait_for(lambda told: (VALUE, value) in told)

    def test_a_mapping_that_is_changed_is_obeyed(self) -> None:
        """CiA 301 7.5.2.36: invalid, no objects, the objects, their number, valid again."""
        self.use(3)
        values = Observer()
        pdo = self.remote.tpdo[SPARE]
        pdo.clear()
        pdo.add_variable(0x6400, 0x07)
        pdo.add_variable(0x6210)
        pdo.cob_id, pdo.trans_type, pdo.enabled = 0x1C2, 1, True
        pdo.save()
        self.remote.sdo[0x6400][0x07].raw = 0x12345678
        self.remote.sdo[0x6210].raw = 0x9ABCDEF0
        pdo.add_callback(lambda pdo: values(bytes(pdo.data)))
        self.start()
        self.net.sync.transmit()
        told = values.wait_for(lambda told: told != [])
        self.assertEqual(told[0], bytes.fromhex("78563412 F0DEBC9A"))

    def test_a_valid_pdo_is_moved_by_one_save(self) -> None:
        """The write that makes it invalid has the new COB-ID already."""
        pdo = self.remote.tpdo[TELEMETRY]
        # There and back: the other tests use it.
        for cob_id in (0x1C2, 0x382):
            self.remote.nmt.state = "PRE-OPERATIONAL"
            self.slave.becomes(PRE_OPERATIONAL)
            self.assertTrue(pdo.enabled)
            pdo.cob_id = cob_id
            pdo.save()
            answers = Observer()
            self.net.subscribe(cob_id, lambda cob_id, data, timestamp: answers(bytes(data)))
            self.start()
            self.send(REQUEST, VALUE, 0)
            answers.wait_for(lambda told: told != [])


if __name__ == "__main__":
    unittest.main(verbosity=2)
