// SPDX-License-Identifier: GPL-3.0-or-later
#include "preprocess/volume/known_volumes.h"

#include <fmt/format.h>

#include <system_error>

namespace mote::prep {
namespace {

using namespace std::string_view_literals;

constexpr std::string_view array = "open it in Python and numpy.save the array: .npy is read";
constexpr std::string_view microscope = "Bio-Formats (bfconvert) or Fiji makes OME-TIFF of it, which is read";
constexpr std::string_view unpack = "unpack it first; a folder may be an input";
constexpr std::string_view paraview = "ParaView saves its data as VTI, which is read";
constexpr std::string_view mesh = "that is a mesh: mote-prep mesh and mote-prep stipple read it";

struct Signature {
    std::size_t offset;
    std::string_view bytes, what, wayOut;
};

constexpr Signature signatures[] = {
    {0, "CDF\x01"sv, "a netCDF file (or MINC-1)", array},
    {0, "CDF\x02"sv, "a netCDF file", array},
    {0, "CDF\x05"sv, "a netCDF file", array},
    {0, "\x89HDF\r\n"sv,
     "an HDF5 file without openPMD's meshes (netCDF-4, MINC-2, Imaris and others are such)",
     "h5py reads it: numpy.save the array, or write openPMD"},
    {0, "\x0e\x03\x13\x01"sv, "an HDF4 file", array},
    {0, "MATLAB 5.0 MAT-file"sv, "a MATLAB file", "scipy.io.loadmat reads it: numpy.save the array"},
    {0, "MATLAB 7.3 MAT-file"sv, "a MATLAB file", "h5py reads it: numpy.save the array"},
    {0, "SIMPLE  ="sv, "a FITS file", "astropy.io.fits reads it: numpy.save the array"},
    {0, "# vtk DataFile"sv, "a VTK file in the old format", paraview},
    {0, "# AmiraMesh"sv, "an Amira file", "Amira exports NRRD; nibabel and others in Python read it"},
    {0, "# Avizo"sv, "an Avizo file", "Avizo exports NRRD"},
    {0, "ZISRAWFILE"sv, "a Zeiss CZI file", microscope},
    {0, "\xda\xce\xbe\x0a"sv, "a Nikon ND2 file", microscope},
    {0, "\x70\0\0\0"sv, "a Leica LIF file", microscope},
    {0, "\xd0\xcf\x11\xe0"sv, "a compound file (Zeiss ZVI, TXM, Olympus OIB, or an office document)",
     microscope},
    {0, "Interfile"sv, "an Interfile header", "dcm2niix or medcon makes NIfTI of it"},
    {0, "!INTERFILE"sv, "an Interfile header", "dcm2niix or medcon makes NIfTI of it"},
    {0, "MATRIX7"sv, "an ECAT file", "dcm2niix or nibabel makes NIfTI of it"},
    {0, "\x5c\x01\0\0"sv, "an Analyze 7.5 header", "nibabel makes NIfTI of it: nibabel.save"},
    {0, "\0\0\x01\x5c"sv, "an Analyze 7.5 header", "nibabel makes NIfTI of it: nibabel.save"},
    {0, "\0\0\x01\xff\xff\xff"sv, "a FreeSurfer file", "mri_convert makes NIfTI of it"},
    {0, "v/1\x01"sv, "an OpenEXR picture", "volumes are stacks of PNG or TIFF: oiiotool converts it"},
    {0, "\xff\xd8\xff"sv, "a JPEG picture", "volumes are stacks of PNG or TIFF, without losses"},
    {0, "\0\0\0\x0cjP  "sv, "a JPEG 2000 picture", "volumes are stacks of PNG or TIFF"},
    {0, "GIF8"sv, "a GIF picture", "volumes are stacks of PNG or TIFF"},
    {0, "BM"sv, "a BMP picture", "volumes are stacks of PNG or TIFF"},
    {0, "ply\n"sv, "a PLY file", mesh},
    {0, "solid "sv, "an STL file", mesh},
    {0, "OFF\n"sv, "an OFF file", mesh},
    {0, "# Wavefront"sv, "an OBJ file", mesh},
    {0, "ADIOS-BP"sv, "an ADIOS2 BP file", "openpmd-pipe --infile x.bp --outfile x.h5 makes HDF5 of it"},
    {0, "BZh"sv, "a bzip2 archive", unpack},
    {0, "\xfd\x37zXZ"sv, "an xz archive", unpack},
    {0, "\x28\xb5\x2f\xfd"sv, "a Zstandard archive", unpack},
    {0, "7z\xbc\xaf"sv, "a 7-Zip archive", unpack},
    {0, "Rar!"sv, "a RAR archive", unpack},
    {257, "ustar"sv, "a tar archive", unpack},
    {0, "\x80\x04"sv, "a Python pickle", "pickles are programs and not read: numpy.save the array"},
    {0, "\x80\x05"sv, "a Python pickle", "pickles are programs and not read: numpy.save the array"},
    {0, "%PDF"sv, "a PDF document", "the numbers behind it are needed"},
    {0, "version https://git-lfs"sv, "a pointer of Git LFS", "git lfs pull brings the file itself"},
};

std::string sentence(std::string_view what, std::string_view wayOut) {
    return fmt::format("is {}, which is not read as a volume; {}", what, wayOut);
}

}  // namespace

std::optional<std::string> knownNoVolume(std::string_view begin) {
    for (const Signature& known : signatures) {
        if (begin.size() < known.offset) continue;
        if (begin.substr(known.offset).starts_with(known.bytes)) return sentence(known.what, known.wayOut);
    }
    if (begin.find("<VTKFile") != std::string_view::npos) return sentence("a VTK XML file", paraview);
    if (begin.find("<Xdmf") != std::string_view::npos) return sentence("an XDMF description", paraview);
    return std::nullopt;
}

std::optional<std::string> knownNoVolumeFolder(const std::filesystem::path& folder) {
    std::error_code code;
    const auto has = [&](const char* name) { return std::filesystem::exists(folder / name, code); };
    if (has(".zgroup") || has(".zattrs") || has(".zarray") || has("zarr.json")) {
        return sentence("a Zarr store", "zarr in Python reads it: numpy.save the array");
    }
    if (has("md.idx")) {
        return sentence("an ADIOS2 BP folder", "openpmd-pipe --infile x.bp --outfile x.h5 makes HDF5 of it");
    }
    if (has("acqp") && has("method")) {
        return sentence("a Bruker ParaVision folder", "dcm2niix or brkraw makes NIfTI of it");
    }
    return std::nullopt;
}

}  // namespace mote::prep
