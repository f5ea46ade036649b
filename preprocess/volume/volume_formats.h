// SPDX-License-Identifier: GPL-3.0-or-later
//
// The readers of volumes, each with what tells its files: rows of volumeReaders (open_volume_source.cpp)
// point at them. All parse bytes that nobody vouches for. Called from one thread.
#pragma once

#include <filesystem>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "preprocess/job.h"
#include "preprocess/volume/volume_shape.h"
#include "preprocess/volume/volume_source.h"
#include "protocol/base/error.h"

namespace mote::prep {

// Which files make a stack of pictures, and in which order.

/// Whether an input names several files: a folder, or a name with * or ? that no file has.
bool namesPictures(const std::filesystem::path& input);

/// Finds its PNG and TIFF files, by their endings, or all files of such names, in natural order. Errors:
/// notFound (none), corrupt (numbers leave one out), resourceExhausted (more than VolumeShape::maxDimension),
/// permissionDenied, internal.
Result<std::vector<std::filesystem::path>> pictureFiles(const std::filesystem::path& input);

/// Orders names in which numbers count as numbers: slice2 before slice10.
bool naturallyLess(std::string_view a, std::string_view b);

// Stacks of pictures: PNG or TIFF files, each a slice, or a TIFF file of several pages. Called from one
// thread.

bool beginsAsPicture(std::string_view bytes);

/// `input` is a folder, a pattern of names (namesPictures) or a TIFF file. Rows from top to bottom are y, the
/// numbers those that the files store: no colour space is undone, no palette looked up. Pictures in colour
/// become their luminance, with a note. `field`: as of chooseParts, of the frames and channels of a file
/// (ImageJ, OME, tifffile), or a channel's name. `progress` is asked while slices are read. Errors: notFound,
/// unsupported (a single picture, another format), corrupt (pictures of different size or type), those of
/// chooseParts, cancelled.
Result<std::unique_ptr<VolumeSource>> openPictureStack(const std::filesystem::path& input,
                                                       const std::string& field, Progress& progress);
Result<VolumeParts> partsOfPictures(const std::filesystem::path& input, const std::string& field,
                                    Progress& progress);

// OpenVDB volumes: one grid of floats, doubles or 32-bit integers, in the box of its active voxels. Called
// from one thread.

bool beginsAsVdb(std::string_view bytes);

/// The grid of the name `field`; "": the first one that can be read. The grid's nodes are in memory, and the
/// voxels of those slices that were asked for last. Errors: notFound (no such grid, none at all), unsupported
/// (vectors, points, a transform that is not linear), corrupt, those of fileStream.
Result<std::unique_ptr<VolumeSource>> openVdb(const std::filesystem::path& path, const std::string& field);

/// Lists all grids, that which is read without a name first. Errors: corrupt, those of fileStream.
Result<std::vector<VolumeField>> vdbFields(const std::filesystem::path& path);

// How many volumes a file has, partsOf..., is what its header says. Errors: those of opening it.

bool beginsAsMetaImage(std::string_view bytes);
/// `path` is the file with the header; it may be gzipped. `field`: as of chooseParts. Errors: corrupt,
/// unsupported (other than three axes, and one of time), permissionDenied (data in another folder), those of
/// chooseParts and fileStream.
Result<std::unique_ptr<VolumeSource>> openMetaImage(const std::filesystem::path& path,
                                                    const std::string& field);
Result<VolumeParts> partsOfMetaImage(const std::filesystem::path& path);

bool beginsAsMrc(std::string_view bytes);
/// The file may be gzipped. The file's columns are the volume's first axis; which one they are in space, the
/// map to the world says. `field`: the number of a volume of a stack. Errors: corrupt, unsupported, those of
/// chooseParts and fileStream.
Result<std::unique_ptr<VolumeSource>> openMrc(const std::filesystem::path& path, const std::string& field);
Result<VolumeParts> partsOfMrc(const std::filesystem::path& path);

bool beginsAsNifti(std::string_view bytes);
/// Each file may be gzipped. `field`: as of chooseParts, of the times and other volumes. Errors: corrupt,
/// unsupported, notFound (no .img file), those of chooseParts and fileStream.
Result<std::unique_ptr<VolumeSource>> openNifti(const std::filesystem::path& path, const std::string& field);
Result<VolumeParts> partsOfNifti(const std::filesystem::path& path);

bool beginsAsNpy(std::string_view bytes);
/// An array of three dimensions, which are z, y and x, or of four, the first of which counts volumes; in C
/// order, or in Fortran's, which is then held whole, at most 1 GiB. `field`: the number of a volume; of an
/// archive, NAME or NAME:NUMBER, where it holds more than one array of so many dimensions. Errors:
/// unsupported (other dimensions, complex numbers, fields, several arrays: a sentence that lists them),
/// notFound, resourceExhausted, those of openNpyArrays and chooseParts.
Result<std::unique_ptr<VolumeSource>> openNpy(const std::filesystem::path& path, const std::string& field);

/// The arrays of an archive that are volumes or series of them. Errors: those of openNpyArrays.
Result<std::vector<VolumeField>> npyFields(const std::filesystem::path& path);

/// The fields of all volumes of the array, if `field` leaves open which. Errors: as openNpy.
Result<std::vector<std::string>> npySteps(const std::filesystem::path& path, const std::string& field);

bool beginsAsNrrd(std::string_view bytes);
/// `path` is the file with the header; it may be gzipped. `field`: as of chooseParts. Errors: corrupt,
/// unsupported (another encoding, not three axes of space), those of chooseParts and fileStream.
Result<std::unique_ptr<VolumeSource>> openNrrd(const std::filesystem::path& path, const std::string& field);
Result<VolumeParts> partsOfNrrd(const std::filesystem::path& path);

bool beginsAsVti(std::string_view bytes);
/// The arrays that may be asked for, that which is read without a name first; of one with several values each
/// of them and its length. Errors: corrupt, unsupported, cancelled, those of fileStream.
Result<std::vector<VolumeField>> vtiFields(const std::filesystem::path& path, const Progress& progress);

/// The array `field`; "": the active scalars, else the first array with one value for each point, else for
/// each cell. Of an array with several values a point, "NAME:1" is the second, "NAME:magnitude" the length of
/// the vector that they are. The file may be gzipped. Errors: corrupt, unsupported (several pieces, another
/// compressor), notFound (no such array), cancelled, those of fileStream.
Result<std::unique_ptr<VolumeSource>> openVti(const std::filesystem::path& path, std::string_view field,
                                              const Progress& progress);

}  // namespace mote::prep
