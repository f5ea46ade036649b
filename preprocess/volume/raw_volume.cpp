// SPDX-License-Identifier: GPL-3.0-or-later
#include "preprocess/volume/raw_volume.h"

#include <fmt/format.h>

#include "preprocess/volume/stream_volume.h"

namespace mote::prep {

Result<std::unique_ptr<VolumeSource>> openRaw(const proto::VolumeSourceOptions& options,
                                              const std::filesystem::path& path) {
    if (options.dimensions_size() != 3) {
        return Error{ErrorCode::invalidArgument, "dimensions", "a raw volume needs three of them"};
    }
    SampleFormat samples;
    samples.bigEndian = options.big_endian();
    const std::string typeName = options.type().empty() ? "u8" : options.type();
    const auto type = scalarType(typeName);
    if (!type) {
        return Error{ErrorCode::invalidArgument, "type",
                     fmt::format("\"{:.20}\" is none of u8, i8, u16, i16, u32, i32, f32 and f64", typeName)};
    }
    samples.type = *type;
    VolumeShape shape;
    shape.type = *type;
    if (const auto status = setDimensions(shape, options.dimensions(0), options.dimensions(1),
                                          options.dimensions(2), "dimensions");
        !status) {
        return Error{ErrorCode::invalidArgument, status.error().where, status.error().message};
    }
    auto file = fileStream(path);
    if (!file) return file.error();
    auto data = partStream(std::move(file).value(), options.header_bytes());
    if (!data) return data.error();
    return StreamVolume::make("raw", std::move(shape), samples, std::move(data).value());
}

}  // namespace mote::prep
