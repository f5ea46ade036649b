# Packages for Debian, made by cpack in the build's folder: mote-view, mote-client, mote-server, mote-prep and
# python3-mote, and mote-adios2 where ADIOS2 is, which would bring sixty libraries to who never reads its files. What they need of
# other packages, dpkg-shlibdeps finds in the programs; deploy/check-packages installs them where nothing else is.
set(CPACK_GENERATOR DEB)
set(CPACK_PACKAGE_NAME mote)
set(CPACK_PACKAGE_CONTACT "The Mote developers")
set(CPACK_PACKAGE_DESCRIPTION_SUMMARY "Remote visualization of particle runs")
set(CPACK_COMPONENTS_ALL view client server prep python)
set(CPACK_DEB_COMPONENT_INSTALL ON)
# Not a prefix of their own while they are packed: the unit names the folder of the programs.
set(CPACK_SET_DESTDIR ON)
set(CPACK_INSTALL_PREFIX /usr)
set(CPACK_STRIP_FILES ON)
set(CPACK_DEBIAN_FILE_NAME DEB-DEFAULT)
set(CPACK_DEBIAN_PACKAGE_SECTION science)
set(CPACK_DEBIAN_PACKAGE_SHLIBDEPS ON)
set(CPACK_DEBIAN_DEBUGINFO_PACKAGE OFF)

set(CPACK_COMPONENT_VIEW_DESCRIPTION
  "Mote's viewer\n mote-view shows what a server draws; mote connects to other machines.")
set(CPACK_COMPONENT_CLIENT_DESCRIPTION
  "Mote's clients\n mote-frames for scripts and films, mote-stats for numbers, mote-web for browsers, beside the viewer.")
set(CPACK_COMPONENT_SERVER_DESCRIPTION
  "Mote's server\n Renders datasets where they lie and streams the pictures to clients. runs jobs that make datasets.")
set(CPACK_COMPONENT_PREP_DESCRIPTION
  "Makes datasets for Mote\n Turns runs of particles, volumes, meshes and images into datasets; alone or on several nodes.")
# The server's jobs run mote-prep, its films mote-frames.
set(CPACK_DEBIAN_SERVER_PACKAGE_DEPENDS "mote-prep (= ${PROJECT_VERSION})")
# What draws on a GPU is loaded where it is there.
set(CPACK_DEBIAN_SERVER_PACKAGE_RECOMMENDS "mote-client (= ${PROJECT_VERSION}), libegl1, libopengl0")
set(CPACK_DEBIAN_PREP_PACKAGE_SUGGESTS "openmpi-bin")
if(TARGET mote-adios2)
  list(APPEND CPACK_COMPONENTS_ALL adios2)
  set(CPACK_COMPONENT_ADIOS2_DESCRIPTION "Files of ADIOS2 for mote-prep\n Reads openPMD in BP4 and BP5.")
  set(CPACK_DEBIAN_ADIOS2_PACKAGE_DEPENDS "mote-prep (= ${PROJECT_VERSION})")
  set(CPACK_DEBIAN_PREP_PACKAGE_SUGGESTS "openmpi-bin, mote-adios2")
endif()
# The viewer loads what decodes H.264 where it is there; without it, pictures of thin lines come as JPEG.
string(REGEX MATCH "^[0-9]+" avcodec "${AVCODEC_libavcodec_VERSION}")
set(CPACK_DEBIAN_VIEW_PACKAGE_RECOMMENDS "libavcodec${avcodec}, fonts-dejavu-core, python3, openssh-client")
set(CPACK_DEBIAN_VIEW_PACKAGE_SUGGESTS "fonts-noto-cjk | fonts-droid-fallback")
set(CPACK_DEBIAN_CLIENT_PACKAGE_DEPENDS "mote-view (= ${PROJECT_VERSION})")
set(CPACK_COMPONENT_PYTHON_DESCRIPTION
  "Mote in Python\n Pictures, numbers and jobs of a server, for scripts and notebooks.")
set(CPACK_DEBIAN_PYTHON_PACKAGE_NAME python3-mote)
set(CPACK_DEBIAN_PYTHON_PACKAGE_SECTION python)
set(CPACK_DEBIAN_PYTHON_PACKAGE_SHLIBDEPS OFF)
set(CPACK_DEBIAN_PYTHON_PACKAGE_ARCHITECTURE all)
set(CPACK_DEBIAN_PYTHON_PACKAGE_DEPENDS
  "python3, python3-numpy, python3-pil, python3-protobuf, python3-zstandard")
set(CPACK_DEBIAN_PYTHON_PACKAGE_RECOMMENDS "mote-server (= ${PROJECT_VERSION})")
set(CPACK_DEBIAN_PYTHON_PACKAGE_CONTROL_EXTRA ${CMAKE_CURRENT_SOURCE_DIR}/python3-mote/prerm)
set(CPACK_DEBIAN_PYTHON_PACKAGE_CONTROL_STRICT_PERMISSION ON)
include(CPack)
