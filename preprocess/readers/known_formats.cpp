// SPDX-License-Identifier: GPL-3.0-or-later
#include "preprocess/readers/known_formats.h"

#include <system_error>

namespace mote::prep {
namespace {

constexpr std::string_view table = "write a table with names (CSV) or openPMD of it";
constexpr std::string_view volume = "that is a volume: mote-prep volume reads it";
constexpr std::string_view mesh = "that is a mesh: mote-prep mesh and mote-prep stipple read it";

constexpr std::size_t fewestSure = 4;

struct Signature {
    std::size_t offset;
    std::string_view bytes;
    std::string_view what;
    std::string_view wayOut;
};

using namespace std::string_view_literals;

// Those that are longer or further in go before those that others begin with.
constexpr Signature signatures[] = {
    {128, "DICM"sv, "a DICOM file", "pictures of patients are volumes: mote-prep volume, or dcm2niix"},
    {344, "n+1\0"sv, "a NIfTI-1 file", volume},
    {344, "ni1\0"sv, "a NIfTI-1 header", volume},
    {4, "n+2\0"sv, "a NIfTI-2 file", volume},
    {208, "MAP "sv, "an MRC or CCP4 map", volume},
    {0, "ADIOS-BP"sv, "an ADIOS2 BP file", "openpmd-pipe --infile x.bp --outfile x.h5 makes HDF5 of it"},
    {0, "root"sv, "a ROOT file", "uproot in Python reads it: write its tree with to_csv or numpy.savez"},
    {0, "CDF\x01"sv, "a netCDF-3 file", "ncdump or xarray reads it: write a table with names (CSV)"},
    {0, "CDF\x02"sv, "a netCDF-3 file", "ncdump or xarray reads it: write a table with names (CSV)"},
    {0, "CDF\x05"sv, "a netCDF-3 file", "ncdump or xarray reads it: write a table with names (CSV)"},
    {0, "\x0e\x03\x13\x01"sv, "an HDF4 file", "h4toh5 makes HDF5 of it; then write openPMD or a table"},
    {0, "MATLAB 5.0 MAT-file"sv, "a MATLAB file",
     "scipy.io.loadmat reads it: write numpy.savez of its arrays"},
    {0, "MATLAB 7.3 MAT-file"sv, "a MATLAB file", "h5py reads it: write numpy.savez of its arrays"},
    {0, "Octave-1-"sv, "an Octave file", "save it with -text as a table with names, or write CSV"},
    {0, "SIMPLE  ="sv, "a FITS file", "astropy.table reads it: write a table with names (CSV)"},
    {0, "PAR1"sv, "a Parquet file", "pandas reads it: DataFrame.to_csv makes a table with names"},
    {0, "ARROW1"sv, "an Arrow file", "pandas reads it: DataFrame.to_csv makes a table with names"},
    {0, "Obj\x01"sv, "an Avro file", table},
    {0, "SQLite format 3"sv, "an SQLite database", "sqlite3 -header -csv writes a table with names"},
    {0, "# vtk DataFile"sv, "a VTK file in the old format",
     "write VTI (a volume), PLY (a mesh) or CSV (particles)"},
    {0, "NRRD000"sv, "an NRRD file", volume},
    {0, "ObjectType = Image"sv, "a MetaImage file", volume},
    {0, "NDims ="sv, "a MetaImage file", volume},
    {0, "\x20\x42\x44\x56"sv, "an OpenVDB file", volume},
    {0, "ply\n"sv, "a PLY file", mesh},
    {0, "ply\r"sv, "a PLY file", mesh},
    {0, "solid "sv, "an STL file", mesh},
    {0, "SOLID "sv, "an STL file", mesh},
    {0, "OFF"sv, "an OFF file", mesh},
    {0, "glTF"sv, "a glTF file", "that is a mesh: write OBJ, PLY or STL of it"},
    {0, "Kaydara FBX"sv, "an FBX file", "that is a mesh: write OBJ, PLY or STL of it"},
    {0, "ISO-10303-21"sv, "a STEP file", "that is a body: mesh it, as STL or OBJ"},
    {0, "$MeshFormat"sv, "a Gmsh mesh",
     "gmsh -save -format stl makes a mesh of it that mote-prep mesh reads"},
    {0, "\x89PNG"sv, "a PNG picture", "mote-prep image and mote-prep volume read pictures"},
    {0, "\xff\xd8\xff"sv, "a JPEG picture", "mote-prep image reads pictures"},
    {0, "II*\0"sv, "a TIFF picture", "mote-prep image and mote-prep volume read pictures"},
    {0, "MM\0*"sv, "a TIFF picture", "mote-prep image and mote-prep volume read pictures"},
    {0, "II+\0"sv, "a BigTIFF picture", "mote-prep image and mote-prep volume read pictures"},
    {0, "v/1\x01"sv, "an OpenEXR picture", "mote-prep image reads pictures"},
    {0, "GIF8"sv, "a GIF picture", "write PNG of it for mote-prep image"},
    {0, "BM"sv, "a BMP picture", "write PNG of it for mote-prep image"},
    {0, "%PDF"sv, "a PDF document", "the numbers behind it are needed: a table, openPMD"},
    {0, "%!PS"sv, "a PostScript document", "the numbers behind it are needed: a table, openPMD"},
    {0,
     "\x7f"
     "ELF"sv,
     "a program", "name the files that it writes"},
    {0, "BZh"sv, "a bzip2 archive", "unpack it first: bunzip2"},
    {0,
     "\xfd"
     "7zXZ"sv,
     "an xz archive", "unpack it first: unxz"},
    {0, "\x28\xb5\x2f\xfd"sv, "a Zstandard archive", "unpack it first: unzstd"},
    {0, "7z\xbc\xaf"sv, "a 7-Zip archive", "unpack it first: 7z x"},
    {0, "Rar!"sv, "a RAR archive", "unpack it first: unrar x"},
    {257, "ustar"sv, "a tar archive", "unpack it first: tar xf; a folder may be an input"},
    {0, "\x80\x02"sv, "a Python pickle",
     "pickles are programs and not read: write numpy.savez of its arrays"},
    {0, "\x80\x03"sv, "a Python pickle",
     "pickles are programs and not read: write numpy.savez of its arrays"},
    {0, "\x80\x04"sv, "a Python pickle",
     "pickles are programs and not read: write numpy.savez of its arrays"},
    {0, "\x80\x05"sv, "a Python pickle",
     "pickles are programs and not read: write numpy.savez of its arrays"},
    {0, "\xd0\xcf\x11\xe0"sv, "an Excel workbook", "save it as CSV, with a line of names"},
    {0, "RDX"sv, "an R data file", "write.csv makes a table with names"},
};

struct Word {
    std::string_view word;
    std::string_view what;
    std::string_view wayOut;
};

// Texts, by a word near their beginning.
constexpr Word words[] = {
    {"<VTKFile type=\"ImageData\"", "a VTK image", volume},
    {"type=\"ImageData\"", "a VTK image", volume},
    {"<VTKFile", "a VTK XML file", "write VTI (a volume), PLY (a mesh) or CSV (particles)"},
    {"<Xdmf", "an XDMF description", "the HDF5 file that it names may be openPMD, or write a table"},
    {"ITEM: TIMESTEP", "a LAMMPS dump", "write a table with names: dump_modify, or ovito"},
    {"<LHEFile", "a Les Houches event file", table},
    {"HepMC::", "a HepMC file", table},
    {"<?xml", "an XML file", table},
    {"<!DOCTYPE", "a web page", "download the file itself"},
    {"<html", "a web page", "download the file itself"},
    {"version https://git-lfs", "a pointer of Git LFS", "git lfs pull brings the file itself"},
};

std::string sentence(std::string_view what, std::string_view wayOut) {
    return "is " + std::string(what) + ", which is not read as particles; " + std::string(wayOut);
}

}  // namespace

std::optional<std::string> knownFormat(std::string_view begin, std::string_view name, bool sure) {
    for (const Signature& known : signatures) {
        if (begin.size() < known.offset) continue;
        if (sure && (known.bytes.size() < fewestSure || known.bytes == "root")) continue;
        if (begin.substr(known.offset).starts_with(known.bytes)) return sentence(known.what, known.wayOut);
    }
    for (const Word& known : words) {
        if (begin.find(known.word) != std::string_view::npos) return sentence(known.what, known.wayOut);
    }
    if (name.ends_with(".zarr") || name == ".zgroup" || name == ".zattrs" || name == "zarr.json") {
        return sentence("a part of a Zarr store", "zarr and numpy in Python read it: write numpy.savez");
    }
    return std::nullopt;
}

std::optional<std::string> knownFolder(const std::filesystem::path& folder) {
    std::error_code code;
    const auto has = [&](const char* name) { return std::filesystem::exists(folder / name, code); };
    const auto extension = folder.extension();
    if (has("md.idx") || has("data.0") || extension == ".bp" || extension == ".bp4" || extension == ".bp5") {
        return "is an ADIOS2 " + std::string(has("mmd.0") ? "BP5" : "BP4") +
               " file, and this mote was built without ADIOS2; convert it with: openpmd-pipe --infile " +
               folder.filename().string() + " --outfile " + folder.stem().string() + ".h5";
    }
    if (has(".zgroup") || has(".zattrs") || has("zarr.json")) {
        return sentence("a Zarr store", "zarr and numpy in Python read it: write numpy.savez");
    }
    if (has("DICOMDIR")) {
        return sentence("a folder of DICOM pictures", "mote-prep volume, or dcm2niix");
    }
    return std::nullopt;
}

}  // namespace mote::prep
