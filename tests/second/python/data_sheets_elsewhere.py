"""EDS and DCF of a slave, which SLAVE_EDS names, and the committed ones as Lely's dcf-tools and as eds-utils read them."""

import os
import unittest
import warnings
from pathlib import Path

import dcf
from eds_utils.core.file_io.read_eds import read_eds

EDS = Path(os.environ["SLAVE_EDS"])
COMMITTED = Path(__file__).parents[3] / "docs/eds"
NODE = 3
#: Receive PDOs of the master map dummy entries, which are no objects (CiA 306). eds-utils looks for them.
WITH_DUMMIES = ("master.dcf", "master.eds")


class DataSheetsElsewhere(unittest.TestCase):
    def setUp(self) -> None:
        self.files = sorted({EDS, EDS.with_name(f"{EDS.stem}-3.dcf"), *COMMITTED.iterdir()})

    def test_dcf_tools_find_nothing_to_complain_of(self) -> None:
        for path in self.files:
            with self.subTest(file=path.name), warnings.catch_warnings():
                warnings.simplefilter("error")
                parsed = dcf.parse_file(str(path))
                self.assertTrue(dcf.lint(parsed))
                # The DCF of the master is that of node 1; an EDS has no Node-ID of its own.
                device = dcf.Device(parsed, {} if path.suffix == ".dcf" else {"NODEID": NODE})
                self.assertEqual(len(device.tpdo), int(parsed["DeviceInfo"]["NrOfTXPDO"]))
                self.assertEqual(len(device.rpdo), int(parsed["DeviceInfo"]["NrOfRXPDO"]))

    def test_dcf_tools_read_identifiers_and_mappings(self) -> None:
        device = dcf.Device(dcf.parse_file(str(COMMITTED / "slave.eds")), {"NODEID": NODE})
        self.assertEqual(device.tpdo[1].cob_id & 0x7FF, 0x180 + NODE)
        self.assertEqual(device[0x1014][0].parse_value(), 0x80 + NODE)
        mapped = [entry.data_type.bits() for entry in device.tpdo[1].mapping.values()]
        self.assertTrue(mapped and sum(mapped) <= 64, mapped)

    def test_eds_utils_mend_nothing(self) -> None:
        # A device need not have objects of every kind.
        allowed = ["AUTO-FIXED: Section [ManufacturerObjects] was missing"]
        for path in self.files:
            with self.subTest(file=path.name):
                if path.name in WITH_DUMMIES:
                    with self.assertRaises(KeyError):
                        read_eds(str(path))
                    continue
                sheet, errors = read_eds(str(path))
                self.assertEqual([error for error in errors if error not in allowed], [])
                self.assertIn(0x1000, sheet.indexes)


if __name__ == "__main__":
    unittest.main(verbosity=2)
