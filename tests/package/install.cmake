# Installs the listed components (all: everything) of a build tree into an empty prefix.
file(REMOVE_RECURSE ${prefix})
foreach(component IN LISTS components)
  set(only --component ${component})
  if(component STREQUAL "all")
    set(only "")
  endif()
  execute_process(COMMAND ${CMAKE_COMMAND} --install ${build} --prefix ${prefix} ${only}
    OUTPUT_QUIET COMMAND_ERROR_IS_FATAL ANY)
endforeach()
