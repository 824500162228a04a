# Turns files into a C++ source that the program is built with, so that it needs no file. It defines a function that returns
# their names and contents, declared by a header. Where this is included:
#
#     afferent_embed(SOURCE HEADER FUNCTION NAMES FILES)    names and files are lists
#
# which has this script run, when something changes, as `cmake -D out=... -P embed_files.cmake`.
if(NOT CMAKE_SCRIPT_MODE_FILE)
  function(afferent_embed out header function names files)
    add_custom_command(OUTPUT ${out}
      COMMAND ${CMAKE_COMMAND} -D out=${out} -D header=${header} -D function=${function} "-D names=${names}"
        "-D files=${files}" -P ${PROJECT_SOURCE_DIR}/cmake/embed_files.cmake
      DEPENDS ${files} ${PROJECT_SOURCE_DIR}/cmake/embed_files.cmake
      VERBATIM)
  endfunction()
  return()
endif()

set(definitions "")
set(table "")
foreach(name file IN ZIP_LISTS names files)
  file(READ ${file} bytes HEX)
  string(LENGTH "${bytes}" digits)
  math(EXPR size "${digits} / 2")
  string(REGEX REPLACE "(................................)" "\\1\n" bytes "${bytes}")
  string(REGEX REPLACE "([0-9a-f][0-9a-f])" "0x\\1," bytes "${bytes}")
  string(MAKE_C_IDENTIFIER ${name} variable)
  string(APPEND definitions "const unsigned char ${variable}[] = {\n${bytes}0};\n")
  string(APPEND table
    "    {\"${name}\", std::string_view(reinterpret_cast<const char*>(${variable}), ${size})},\n")
endforeach()
file(WRITE ${out}
  "// Made by cmake/embed_files.cmake.\n#include \"${header}\"\n\nnamespace afferent {\nnamespace {\n\n${definitions}\n"
  "using EmbeddedFile = std::pair<std::string_view, std::string_view>;\nconst EmbeddedFile ${function}_table[] = {\n${table}};\n\n}  // namespace\n\n"
  "std::span<const EmbeddedFile> ${function}() noexcept { return ${function}_table; }\n\n}  // namespace afferent\n")
