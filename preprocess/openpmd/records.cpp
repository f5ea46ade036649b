// SPDX-License-Identifier: GPL-3.0-or-later
#include "preprocess/openpmd/records.h"

namespace mote::prep {

bool describeRecord(hid_t record, const RecordKind& kind) {
    return setDoubles(record, "unitDimension", kind.dimension) && setDouble(record, "timeOffset", 0.0) &&
           setUnsigned32(record, "macroWeighted", kind.macroWeighted) &&
           setDouble(record, "weightingPower", kind.weightingPower);
}

bool setConstant(hid_t component, double value, double unit, std::uint64_t rows) {
    return setDouble(component, "value", value) && setExtent(component, "shape", rows) &&
           setDouble(component, "unitSI", unit);
}

bool addConstantScalar(hid_t species, const RecordKind& kind, double value, std::uint64_t rows) {
    const H5Handle record = createGroup(species, kind.name);
    return record.ok() && describeRecord(record.get(), kind) && setConstant(record.get(), value, 1.0, rows);
}

bool addScalar(hid_t species, const RecordKind& kind, hid_t type, double unit, std::uint64_t rows) {
    const H5Handle column = createColumn(species, kind.name, type, rows);
    return column.ok() && describeRecord(column.get(), kind) && setDouble(column.get(), "unitSI", unit);
}

}  // namespace mote::prep
