# SPDX-License-Identifier: GPL-3.0-or-later
# cmake -DPROTOC=... -DROOT=... -DOUT=... -P generate.cmake: the C++ of the schema. Of its header comments are taken out,
# in which protoc repeats what stands on a field: so what changes comments or facts alone compiles one file, not all that
# include the header. It needs nothing of options.proto either, which takes the descriptors' own header with it.
file(MAKE_DIRECTORY ${OUT}/new)
execute_process(COMMAND ${PROTOC} -I ${ROOT} --cpp_out ${OUT}/new protocol/options.proto protocol/mote.proto
                COMMAND_ERROR_IS_FATAL ANY)
set(made ${OUT}/new/protocol)
file(READ ${made}/mote.pb.h header)
string(REGEX REPLACE "\n *//[^\n]*" "" header "${header}")
string(REPLACE "#include \"protocol/options.pb.h\"\n" "" header "${header}")
file(WRITE ${made}/mote.pb.h "${header}")
file(READ ${made}/mote.pb.cc source)
string(REPLACE "#include \"protocol/mote.pb.h\"\n" "#include \"protocol/mote.pb.h\"\n#include \"protocol/options.pb.h\"\n"
       source "${source}")
file(WRITE ${made}/mote.pb.cc "${source}")
foreach(name mote.pb.h mote.pb.cc options.pb.h options.pb.cc)
  configure_file(${made}/${name} ${OUT}/protocol/${name} COPYONLY)
endforeach()
