# SPDX-License-Identifier: GPL-3.0-or-later
"""One beam, written as other codes write theirs and in every legal way that was thought of: read as the same beam, or refused
in a sentence. numpy and h5py write it and read the dataset; no code of ours is asked."""
import unittest

from particle_codes import Gpt, Ocelot, Opal, PyOrbit, Spiffe, Tfs
from particle_records import OpenPmd, Refusals
from particle_runs import Astra, Genesis, H5Part, ImpactT, ImpactZ, Sdds, TraceWin
from particle_tables import Tables, Xsuite

__all__ = ["Astra", "Genesis", "Gpt", "H5Part", "ImpactT", "ImpactZ", "Ocelot", "Opal", "OpenPmd", "PyOrbit", "Refusals", "Sdds", "Spiffe",
           "Tables", "Tfs", "TraceWin", "Xsuite"]

if __name__ == "__main__":
    unittest.main()
