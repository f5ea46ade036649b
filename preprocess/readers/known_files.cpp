// SPDX-License-Identifier: GPL-3.0-or-later
#include "preprocess/readers/known_files.h"

#include <fmt/format.h>

#include <algorithm>
#include <initializer_list>
#include <system_error>

#include "preprocess/readers/adios2/bp_tree.h"

namespace mote::prep {
namespace {

using namespace std::string_view_literals;

constexpr std::size_t fewestSure = 4;

/// What makes one that is read of a file: as particles, as a volume.
namespace way {
constexpr std::string_view table = "write a table with names (CSV) or openPMD of it",
                           csv = "pandas reads it: DataFrame.to_csv makes a table with names",
                           dumped = "ncdump or xarray reads it: write a table with names (CSV)",
                           array = "open it in Python and numpy.save the array: .npy is read",
                           volume = "that is a volume: mote-prep volume reads it",
                           mesh = "that is a mesh: mote-prep mesh and mote-prep stipple read it",
                           otherMesh = "that is a mesh: write OBJ, PLY or STL of it",
                           picture = "mote-prep image reads pictures",
                           pictures = "mote-prep image and mote-prep volume read pictures",
                           png = "write PNG of it for mote-prep image",
                           stack = "volumes are stacks of PNG or TIFF, without losses",
                           numbers = "the numbers behind it are needed: a table, openPMD, an array (.npy)",
                           pickle = "pickles are programs and not read: write numpy.savez of its arrays",
                           vtk = "ParaView writes VTI (a volume), PLY (a mesh) or CSV (particles) of it",
                           microscope = "Bio-Formats (bfconvert) or Fiji makes OME-TIFF of it, which is read",
                           nifti = "dcm2niix, medcon or nibabel makes NIfTI of it",
                           adios = "openpmd-pipe --infile x.bp --outfile x.h5 makes HDF5 of it",
                           lfs = "git lfs pull brings the file itself";
}  // namespace way

struct KnownFile {
    std::size_t offset;
    std::string_view bytes, what;
    std::string_view asParticles, asVolume;  ///< "": read as such, or not told by this
};

// Those that are longer or further in go before those that others begin with.
constexpr KnownFile knownBegins[] = {
    {128, "DICM"sv, "a DICOM file", "pictures of patients are volumes: mote-prep volume, or dcm2niix", ""},
    {344, "n+1\0"sv, "a NIfTI-1 file", way::volume, ""},
    {344, "ni1\0"sv, "a NIfTI-1 header", way::volume, ""},
    {4, "n+2\0"sv, "a NIfTI-2 file", way::volume, ""},
    {208, "MAP "sv, "an MRC or CCP4 map", way::volume, ""},
    {0, "ADIOS-BP"sv, "an ADIOS2 BP file", way::adios, way::adios},
    {0, "root\0"sv, "a ROOT file", "uproot in Python reads it: write its tree with to_csv or numpy.savez",
     ""},
    {0, "CDF\x01"sv, "a netCDF-3 file (or MINC-1)", way::dumped, way::array},
    {0, "CDF\x02"sv, "a netCDF-3 file", way::dumped, way::array},
    {0, "CDF\x05"sv, "a netCDF-3 file", way::dumped, way::array},
    {0, "\x89HDF\r\n"sv,
     "an HDF5 file without openPMD's meshes (netCDF-4, MINC-2, Imaris and others are such)", "",
     "h5py reads it: numpy.save the array, or write openPMD"},
    {0, "\x0e\x03\x13\x01"sv, "an HDF4 file", "h4toh5 makes HDF5 of it; then write openPMD or a table",
     way::array},
    {0, "MATLAB 5.0 MAT-file"sv, "a MATLAB file",
     "scipy.io.loadmat reads it: write numpy.savez of its arrays",
     "scipy.io.loadmat reads it: numpy.save the array"},
    {0, "MATLAB 7.3 MAT-file"sv, "a MATLAB file", "h5py reads it: write numpy.savez of its arrays",
     "h5py reads it: numpy.save the array"},
    {0, "Octave-1-"sv, "an Octave file", "save it with -text as a table with names, or write CSV", ""},
    {0, "SIMPLE  ="sv, "a FITS file", "astropy.table reads it: write a table with names (CSV)",
     "astropy.io.fits reads it: numpy.save the array"},
    {0, "PAR1"sv, "a Parquet file", way::csv, ""},
    {0, "ARROW1"sv, "an Arrow file", way::csv, ""},
    {0, "Obj\x01"sv, "an Avro file", way::table, ""},
    {0, "SQLite format 3"sv, "an SQLite database", "sqlite3 -header -csv writes a table with names", ""},
    {0, "# vtk DataFile"sv, "a VTK file in the old format", way::vtk, way::vtk},
    {0, "# AmiraMesh"sv, "an Amira file", "", "Amira exports NRRD; nibabel and others in Python read it"},
    {0, "# Avizo"sv, "an Avizo file", "", "Avizo exports NRRD"},
    {0, "ZISRAWFILE"sv, "a Zeiss CZI file", "", way::microscope},
    {0, "\xda\xce\xbe\x0a"sv, "a Nikon ND2 file", "", way::microscope},
    {0, "\x70\0\0\0"sv, "a Leica LIF file", "", way::microscope},
    {0, "\xd0\xcf\x11\xe0"sv, "an Excel workbook", "save it as CSV, with a line of names", ""},
    {0, "\xd0\xcf\x11\xe0"sv, "a compound file (Zeiss ZVI, TXM, Olympus OIB, or an office document)", "",
     way::microscope},
    {0, "Interfile"sv, "an Interfile header", "", way::nifti},
    {0, "!INTERFILE"sv, "an Interfile header", "", way::nifti},
    {0, "MATRIX7"sv, "an ECAT file", "", way::nifti},
    {0, "\x5c\x01\0\0"sv, "an Analyze 7.5 header", "", way::nifti},
    {0, "\0\0\x01\x5c"sv, "an Analyze 7.5 header", "", way::nifti},
    {0, "\0\0\x01\xff\xff\xff"sv, "a FreeSurfer file", "", "mri_convert makes NIfTI of it"},
    {0, "NRRD000"sv, "an NRRD file", way::volume, ""},
    {0, "ObjectType = Image"sv, "a MetaImage file", way::volume, ""},
    {0, "NDims ="sv, "a MetaImage file", way::volume, ""},
    {0, "\x20\x42\x44\x56"sv, "an OpenVDB file", way::volume, ""},
    {0, "ply\n"sv, "a PLY file", way::mesh, way::mesh},
    {0, "ply\r"sv, "a PLY file", way::mesh, way::mesh},
    {0, "solid "sv, "an STL file", way::mesh, way::mesh},
    {0, "SOLID "sv, "an STL file", way::mesh, way::mesh},
    {0, "OFF"sv, "an OFF file", way::mesh, way::mesh},
    {0, "# Wavefront"sv, "an OBJ file", "", way::mesh},
    {0, "glTF"sv, "a glTF file", way::otherMesh, way::otherMesh},
    {0, "Kaydara FBX"sv, "an FBX file", way::otherMesh, way::otherMesh},
    {0, "ISO-10303-21"sv, "a STEP file", "that is a body: mesh it, as STL or OBJ",
     "that is a body: mesh it, as STL or OBJ"},
    {0, "$MeshFormat"sv, "a Gmsh mesh", "gmsh -save -format stl makes a mesh of it that mote-prep mesh reads",
     "gmsh -save -format stl makes a mesh of it that mote-prep mesh reads"},
    {0, "\x89PNG"sv, "a PNG picture", way::pictures, ""},
    {0, "\xff\xd8\xff"sv, "a JPEG picture", way::picture, way::stack},
    {0, "\0\0\0\x0cjP  "sv, "a JPEG 2000 picture", way::picture, way::stack},
    {0, "II*\0"sv, "a TIFF picture", way::pictures, ""},
    {0, "MM\0*"sv, "a TIFF picture", way::pictures, ""},
    {0, "II+\0"sv, "a BigTIFF picture", way::pictures, ""},
    {0, "v/1\x01"sv, "an OpenEXR picture", way::picture, way::stack},
    {0, "GIF8"sv, "a GIF picture", way::png, way::stack},
    {0, "BM"sv, "a BMP picture", way::png, way::stack},
    {0, "%PDF"sv, "a PDF document", way::numbers, way::numbers},
    {0, "%!PS"sv, "a PostScript document", way::numbers, way::numbers},
    {0, "\x7f\x45LF"sv, "a program", "name the files that it writes", "name the files that it writes"},
    {0, "BZh"sv, "a bzip2 archive", "unpack it first: bunzip2", "unpack it first: bunzip2"},
    {0, "\xfd\x37zXZ"sv, "an xz archive", "unpack it first: unxz", "unpack it first: unxz"},
    {0, "\x28\xb5\x2f\xfd"sv, "a Zstandard archive", "unpack it first: unzstd", "unpack it first: unzstd"},
    {0, "7z\xbc\xaf"sv, "a 7-Zip archive", "unpack it first: 7z x", "unpack it first: 7z x"},
    {0, "Rar!"sv, "a RAR archive", "unpack it first: unrar x", "unpack it first: unrar x"},
    {257, "ustar"sv, "a tar archive", "unpack it first: tar xf; a folder may be an input",
     "unpack it first: tar xf; a folder may be an input"},
    {0, "\x80\x02"sv, "a Python pickle", way::pickle, way::pickle},
    {0, "\x80\x03"sv, "a Python pickle", way::pickle, way::pickle},
    {0, "\x80\x04"sv, "a Python pickle", way::pickle, way::pickle},
    {0, "\x80\x05"sv, "a Python pickle", way::pickle, way::pickle},
    {0, "RDX"sv, "an R data file", "write.csv makes a table with names", way::array},
};

constexpr std::size_t anywhere = 0;

// Texts, by a word near their beginning.
constexpr KnownFile knownWords[] = {
    {anywhere, "type=\"ImageData\"", "a VTK image", way::volume, ""},
    {anywhere, "<VTKFile", "a VTK XML file", way::vtk, way::vtk},
    {anywhere, "<Xdmf", "an XDMF description", "the HDF5 file that it names may be openPMD, or write a table",
     "ParaView saves its data as VTI"},
    {anywhere, "ITEM: TIMESTEP", "a LAMMPS dump", "write a table with names: dump_modify, or ovito", ""},
    {anywhere, "<LHEFile", "a Les Houches event file", way::table, ""},
    {anywhere, "HepMC::", "a HepMC file", way::table, ""},
    {anywhere, "<?xml", "an XML file", way::table, ""},
    {anywhere, "<!DOCTYPE", "a web page", "download the file itself", "download the file itself"},
    {anywhere, "<html", "a web page", "download the file itself", "download the file itself"},
    {anywhere, "version https://git-lfs", "a pointer of Git LFS", way::lfs, way::lfs},
};

std::string knownSentence(std::string_view what, std::string_view wayOut, WantedAs wanted) {
    return fmt::format("is {}, which is not read as {}; {}", what,
                       wanted == WantedAs::particles ? "particles" : "a volume", wayOut);
}

constexpr std::string_view zarrArrays = "zarr and numpy in Python read it: write numpy.savez, or numpy.save";

}  // namespace

std::optional<std::string> knownFile(std::string_view begin, std::string_view name, WantedAs wanted,
                                     bool sure) {
    const auto wayOut = [&](const KnownFile& known) {
        return wanted == WantedAs::particles ? known.asParticles : known.asVolume;
    };
    for (const KnownFile& known : knownBegins) {
        if (begin.size() < known.offset || wayOut(known).empty()) continue;
        if (sure && known.bytes.size() < fewestSure) continue;
        if (begin.substr(known.offset).starts_with(known.bytes))
            return knownSentence(known.what, wayOut(known), wanted);
    }
    for (const KnownFile& known : knownWords) {
        if (!wayOut(known).empty() && begin.find(known.bytes) != std::string_view::npos)
            return knownSentence(known.what, wayOut(known), wanted);
    }
    if (name.ends_with(".zarr") || name == ".zgroup" || name == ".zattrs" || name == "zarr.json")
        return knownSentence("a part of a Zarr store", zarrArrays, wanted);
    return std::nullopt;
}

std::optional<std::string> knownFolder(const std::filesystem::path& folder, WantedAs wanted) {
    if (BpTree::reads(folder)) return std::nullopt;
    const auto hasOne = [&](std::initializer_list<const char*> names) {
        std::error_code code;
        return std::any_of(names.begin(), names.end(),
                           [&](const char* name) { return std::filesystem::exists(folder / name, code); });
    };
    const auto extension = folder.extension();
    if (hasOne({"md.idx"}) || (wanted == WantedAs::particles && hasOne({"data.0"})) || extension == ".bp" ||
        extension == ".bp4" || extension == ".bp5") {
        if (openBp() != nullptr) return "is an ADIOS2 file without its md.idx: it was not written to its end";
        return fmt::format(
            "is an ADIOS2 {} file, and this mote was built without ADIOS2; convert it with: openpmd-pipe "
            "--infile {} --outfile {}.h5",
            hasOne({"mmd.0"}) ? "BP5" : "BP4", folder.filename().string(), folder.stem().string());
    }
    if (hasOne({".zgroup", ".zattrs", ".zarray", "zarr.json"}))
        return knownSentence("a Zarr store", zarrArrays, wanted);
    if (wanted == WantedAs::particles && hasOne({"DICOMDIR"}))
        return knownSentence("a folder of DICOM pictures", "mote-prep volume, or dcm2niix", wanted);
    if (wanted == WantedAs::volume && hasOne({"acqp"}) && hasOne({"method"}))
        return knownSentence("a Bruker ParaVision folder", "dcm2niix or brkraw makes NIfTI of it", wanted);
    return std::nullopt;
}

}  // namespace mote::prep
