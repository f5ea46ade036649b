// SPDX-License-Identifier: GPL-3.0-or-later
//
// HDF5 does not stand any bytes: it writes the files that our readers then read.
#include <algorithm>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "preprocess/readers/hdf5/h5_file.h"
#include "tests/fuzz/input_folder.h"
#include "tests/fuzz/inputs.h"
#include "tests/fuzz/read_source.h"
#include "tests/fuzz/require.h"

namespace mote::test {
namespace {

// HDF5 files from a few lines of text, which may say anything. Of one thread, as HDF5 is.
//
//   group PATH                           soft PATH TARGET    hard PATH TARGET    external PATH
//   data PATH TYPE SHAPE STORAGE VALUE...
//   numbers PATH NAME TYPE SHAPE VALUE...     an attribute
//   text PATH NAME KIND TEXT                  an attribute; TEXT may be TEXT|TEXT...
//   cut BYTES                                 off the file's end
//
// PATH: groups on the way are made, too. TYPE: i8, u8, ..., f64, with "be" behind it big-endian; or enum,
// text, opaque, compound. SHAPE: 3x4, "-" for one value, "null" for none. STORAGE: plain, compact, unwritten,
// external, chunks, deflate, shuffle, fletcher, nbit, several joined by commas. VALUE: from the first one
// again where there are too few; 0, 1, 2... if there is none. KIND: fixed or variable.

using prep::H5Handle;

constexpr std::size_t mostLines = 256, mostDimensions = 5, mostValues = 1 << 14, mostTexts = 32;

/// Groups on the way to what a link stands for are made.
H5Handle linkProperties() {
    H5Handle properties(H5Pcreate(H5P_LINK_CREATE), H5Pclose);
    H5Pset_create_intermediate_group(properties.get(), 1);
    return properties;
}

H5Handle typeOf(std::string name) {
    if (name == "text") return H5Handle(H5Tcopy(H5T_C_S1), H5Tclose);
    if (name == "opaque") return H5Handle(H5Tcreate(H5T_OPAQUE, 32), H5Tclose);
    if (name == "enum") return H5Handle(H5Tenum_create(H5T_STD_I8LE), H5Tclose);
    if (name == "compound") {
        H5Handle type(H5Tcreate(H5T_COMPOUND, 8), H5Tclose);
        H5Tinsert(type.get(), "r", 0, H5T_IEEE_F64LE);
        return type;
    }
    const bool big = name.ends_with("be");
    if (big) name.resize(name.size() - 2);
    hid_t plain = H5T_IEEE_F64LE;
    if (name == "i8") plain = H5T_STD_I8LE;
    if (name == "u8") plain = H5T_STD_U8LE;
    if (name == "i16") plain = H5T_STD_I16LE;
    if (name == "u16") plain = H5T_STD_U16LE;
    if (name == "i32") plain = H5T_STD_I32LE;
    if (name == "u32") plain = H5T_STD_U32LE;
    if (name == "i64") plain = H5T_STD_I64LE;
    if (name == "u64") plain = H5T_STD_U64LE;
    if (name == "f32") plain = H5T_IEEE_F32LE;
    H5Handle type(H5Tcopy(plain), H5Tclose);
    if (big) H5Tset_order(type.get(), H5T_ORDER_BE);
    return type;
}

bool isNumber(hid_t type) {
    const auto kind = H5Tget_class(type);
    return kind == H5T_INTEGER || kind == H5T_FLOAT;
}

struct Shape {
    std::vector<hsize_t> extent;
    H5Handle space;
    std::size_t values = 0;  ///< more than mostValues: too many to be written
};

Shape shapeOf(const std::string& text) {
    if (text == "null") return {{}, H5Handle(H5Screate(H5S_NULL), H5Sclose), 0};
    if (text == "-") return {{}, H5Handle(H5Screate(H5S_SCALAR), H5Sclose), 1};
    Shape shape{{}, {}, 1};
    for (Words words(text, 'x'); !words.atEnd() && shape.extent.size() < mostDimensions;) {
        const auto length = words.number<std::uint32_t>(2);
        shape.extent.push_back(length);
        shape.values = std::min<std::uint64_t>(shape.values * std::uint64_t{length}, mostValues + 1);
    }
    const auto rank = static_cast<int>(shape.extent.size());
    shape.space = H5Handle(H5Screate_simple(rank, shape.extent.data(), nullptr), H5Sclose);
    return shape;
}

std::vector<double> valuesOf(Words words, std::size_t count) {
    std::vector<double> given, values(count);
    while (!words.atEnd() && given.size() < count) given.push_back(words.number(0.0));
    for (std::size_t i = 0; i < count; ++i)
        values[i] = given.empty() ? static_cast<double>(i) : given[i % given.size()];
    return values;
}

/// What is no number is written as zeros.
template <class Write>
void writeValues(hid_t type, const Shape& shape, Words words, const Write& write) {
    if (shape.values == 0 || shape.values > mostValues) return;
    if (isNumber(type)) {
        write(H5T_NATIVE_DOUBLE, valuesOf(words, shape.values).data());
    } else {
        write(type, std::vector<char>(shape.values * H5Tget_size(type)).data());
    }
}

/// Three chunks along each dimension.
void setChunks(hid_t properties, const Shape& shape) {
    std::vector<hsize_t> chunk;
    for (const auto length : shape.extent) chunk.push_back(std::max<hsize_t>(1, (length + 2) / 3));
    if (!chunk.empty()) H5Pset_chunk(properties, static_cast<int>(chunk.size()), chunk.data());
}

/// False if nothing is to be written.
bool setStorage(hid_t properties, const std::string& storage, const Shape& shape) {
    bool written = true;
    for (Words words(storage, ','); !words.atEnd();) {
        const std::string word = words.next();
        const bool outside = word == "external";
        if (word == "compact") H5Pset_layout(properties, H5D_COMPACT);
        if (word == "chunks") setChunks(properties, shape);
        if (word == "deflate") H5Pset_deflate(properties, 6);
        if (word == "shuffle") H5Pset_shuffle(properties);
        if (word == "fletcher") H5Pset_fletcher32(properties);
        if (word == "nbit") H5Pset_nbit(properties);
        if (outside) H5Pset_external(properties, "elsewhere", 0, H5F_UNLIMITED);
        if (outside || word == "unwritten") written = false;
    }
    return written;
}

void addData(hid_t file, Words words) {
    const std::string path = words.next();
    const H5Handle type = typeOf(words.next());
    const Shape shape = shapeOf(words.next());
    const H5Handle links = linkProperties(), storage(H5Pcreate(H5P_DATASET_CREATE), H5Pclose);
    const bool written = setStorage(storage.get(), words.next(), shape);
    // HDF5 1.10 takes memory for all of what is to be written.
    if (written && shape.values > mostValues) return;
    const H5Handle data(H5Dcreate2(file, path.c_str(), type.get(), shape.space.get(), links.get(),
                                   storage.get(), H5P_DEFAULT),
                        H5Dclose);
    if (!data.ok() || !written) return;
    writeValues(type.get(), shape, words, [&](hid_t memory, const void* values) {
        H5Dwrite(data.get(), memory, H5S_ALL, H5S_ALL, H5P_DEFAULT, values);
    });
}

H5Handle attributeOf(hid_t file, const std::string& path, const std::string& name, hid_t type, hid_t space) {
    const H5Handle object(H5Oopen(file, path.c_str(), H5P_DEFAULT), H5Oclose);
    if (!object.ok()) return {};
    return {H5Acreate2(object.get(), name.c_str(), type, space, H5P_DEFAULT, H5P_DEFAULT), H5Aclose};
}

void addNumbers(hid_t file, Words words) {
    const std::string path = words.next(), name = words.next();
    const H5Handle type = typeOf(words.next());
    const Shape shape = shapeOf(words.next());
    if (shape.values > mostValues) return;
    const H5Handle attribute = attributeOf(file, path, name, type.get(), shape.space.get());
    if (!attribute.ok()) return;
    writeValues(type.get(), shape, words,
                [&](hid_t memory, const void* values) { H5Awrite(attribute.get(), memory, values); });
}

void addText(hid_t file, Words words) {
    const std::string path = words.next(), name = words.next();
    const bool variable = words.next() == "variable";
    std::vector<std::string> texts;
    std::size_t longest = 1;
    for (Words each(words.rest(), '|'); !each.atEnd() && texts.size() < mostTexts;) {
        texts.push_back(each.next());
        longest = std::max(longest, texts.back().size());
    }
    const H5Handle type(H5Tcopy(H5T_C_S1), H5Tclose);
    H5Tset_size(type.get(), variable ? H5T_VARIABLE : longest);
    const hsize_t count = texts.size();
    const H5Handle space(texts.size() == 1 ? H5Screate(H5S_SCALAR) : H5Screate_simple(1, &count, nullptr),
                         H5Sclose);
    const H5Handle attribute = attributeOf(file, path, name, type.get(), space.get());
    if (!attribute.ok() || texts.empty()) return;
    std::vector<const char*> places;
    std::string fixed;
    for (auto& text : texts) {
        places.push_back(text.c_str());
        fixed += text + std::string(longest - text.size(), '\0');
    }
    H5Awrite(attribute.get(), type.get(),
             variable ? static_cast<const void*>(places.data()) : static_cast<const void*>(fixed.data()));
}

void addLink(hid_t file, const std::string& kind, Words words) {
    const std::string path = words.next(), target = words.next();
    const H5Handle links = linkProperties();
    if (kind == "soft") H5Lcreate_soft(target.c_str(), file, path.c_str(), links.get(), H5P_DEFAULT);
    if (kind == "hard") H5Lcreate_hard(file, target.c_str(), file, path.c_str(), links.get(), H5P_DEFAULT);
    if (kind == "external")
        H5Lcreate_external("elsewhere.h5", "/", file, path.c_str(), links.get(), H5P_DEFAULT);
    if (kind == "group")
        H5Handle(H5Gcreate2(file, path.c_str(), links.get(), H5P_DEFAULT, H5P_DEFAULT), H5Gclose);
}

/// In memory alone.
H5Handle makeFile() {
    const H5Handle access(H5Pcreate(H5P_FILE_ACCESS), H5Pclose);
    H5Pset_fapl_core(access.get(), 1 << 16, 0);
    return {H5Fcreate("fuzz", H5F_ACC_TRUNC, H5P_DEFAULT, access.get()), H5Fclose};
}

std::string imageOf(hid_t file) {
    H5Fflush(file, H5F_SCOPE_GLOBAL);
    const auto size = std::max<ssize_t>(0, H5Fget_file_image(file, nullptr, 0));
    std::string bytes(static_cast<std::size_t>(size), '\0');
    if (size > 0) H5Fget_file_image(file, bytes.data(), bytes.size());
    return bytes;
}

/// The file's bytes. What HDF5 does not take is left out; "" if there is nothing left.
std::string hdf5Of(std::string_view text) {
    prep::silenceHdf5();
    const H5Handle file = makeFile();
    require(file.ok());
    std::size_t cut = 0;
    for (std::size_t i = 0; i < mostLines && !text.empty(); ++i) {
        const auto [line, rest] = firstLine(text);
        text = rest;
        Words words(line);
        const std::string kind = words.next();
        if (kind == "data") {
            addData(file.get(), words);
        } else if (kind == "numbers") {
            addNumbers(file.get(), words);
        } else if (kind == "text") {
            addText(file.get(), words);
        } else if (kind == "cut") {
            cut = words.number<std::size_t>(1);
        } else {
            addLink(file.get(), kind, words);
        }
    }
    std::string bytes = imageOf(file.get());
    bytes.resize(bytes.size() - std::min(bytes.size(), cut));
    return bytes;
}

/// "FORMAT [SPECIES [MASS [twice]]]"; "-" is no species.
std::string readParticlesOf(const std::filesystem::path& file, Words words) {
    proto::ParticlesJob job;
    job.set_format(words.next());
    const std::string species = words.next();
    if (species != "-") job.set_species(species);
    if (!words.atEnd()) job.mutable_impact()->set_mass(words.number(0.0));
    std::vector<std::filesystem::path> inputs{file};
    if (words.next() == "twice") inputs.push_back(file);
    return readParticles(job, inputs);
}

}  // namespace

std::string hdf5Input(std::string_view input) {
    const auto [line, text] = firstLine(input);
    Words words(line);
    const std::string bytes = hdf5Of(text);
    if (bytes.empty()) return "HDF5 made no file of it";
    // HDF5 wants a path that stays one when it is resolved.
    const InputFolder folder;
    folder.write("run.h5", bytes);
    const auto file = folder.path() / "run.h5";
    const std::string what = words.next();
    if (what == "particles") return readParticlesOf(file, words);
    proto::VolumeSourceOptions options;
    options.set_format(words.next());
    options.set_field(words.next());
    return readVolume(options, file);
}

}  // namespace mote::test
