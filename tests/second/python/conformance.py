"""CiA 301, rule by rule, by frames alone: slave 3, whose master is this script (python-can).

A case sends frames and says which ones answer; a rule that is not kept makes it fail. Ten of them are seen to fail against a
server that breaks their rule: what the slave sends is falsified on its way. The number of cases is printed. The variable
DEVICE names the slave: `conformance_devices.py` lists the cases that do not apply to it.
"""

import faulthandler
import random
import unittest

# Each has cases.
import conformance_nmt
import conformance_objects
import conformance_pdo
import conformance_sdo

from conformance_bench import CASES, FALSIFIED, Bench
from conformance_devices import DEVICE

# There are many cases.
faulthandler.dump_traceback_later(900, exit=True)

APPLICABLE = [case for case in CASES if case.name not in DEVICE.not_applicable]


class Conformance(unittest.TestCase):
    def setUp(self) -> None:
        self.bench = Bench()
        self.addCleanup(self.bench.close)

    def test_0_each_case_applies_or_has_a_reason_not_to(self) -> None:
        self.assertEqual(set(DEVICE.not_applicable) - {case.name for case in CASES}, set())
        self.assertEqual(len(APPLICABLE), DEVICE.cases)

    def test_1_every_case(self) -> None:
        for case in APPLICABLE:
            with self.subTest(case=case.name):
                self.bench.prepare()
                case.run(self.bench)
        print(f"{len(APPLICABLE)} cases")

    def test_2_ten_cases_fail_where_their_rule_is_broken(self) -> None:
        cases = {case.name: case for case in APPLICABLE}
        chosen = random.Random(301).sample(sorted(FALSIFIED.keys() & cases.keys()), 10)
        for name in chosen:
            with self.subTest(case=name):
                self.bench.prepare()
                with self.bench.falsified(FALSIFIED[name]), self.assertRaises(AssertionError):
                    cases[name].run(self.bench)


if __name__ == "__main__":
    unittest.main(verbosity=2)
