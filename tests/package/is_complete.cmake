# Fails where an installation lacks what a packager expects. It goes below DESTDIR, one component after the other, and
# gives what all of them at once give.
set(destdir ${folder}/destdir)
file(REMOVE_RECURSE ${folder})
execute_process(COMMAND ${CMAKE_COMMAND} -E env --unset=DESTDIR ${CMAKE_COMMAND} --install ${build} --prefix ${folder}/whole
  OUTPUT_QUIET COMMAND_ERROR_IS_FATAL ANY)
foreach(component IN LISTS components)
  execute_process(COMMAND ${CMAKE_COMMAND} -E env DESTDIR=${destdir} ${CMAKE_COMMAND} --install ${build} --prefix /opt/afferent
      --component ${component}
    OUTPUT_QUIET COMMAND_ERROR_IS_FATAL ANY)
endforeach()
file(GLOB_RECURSE whole RELATIVE ${folder}/whole ${folder}/whole/*)
file(GLOB_RECURSE parts RELATIVE ${destdir}/opt/afferent ${destdir}/opt/afferent/*)
list(SORT whole)
list(SORT parts)
if(NOT whole STREQUAL parts)
  list(REMOVE_ITEM whole ${parts})
  message(FATAL_ERROR "components ${components} do not install ${whole}")
endif()

foreach(expected bin/afferent bin/afferent-hdf5 lib.*/libafferent[.]so[.][0-9.]+ lib.*/pkgconfig/afferent.pc
        lib.*/pkgconfig/afferent-decoders.pc lib.*/cmake/afferent/afferent-config.cmake include/afferent/engine/afferent.h
        share/man/man1/afferent.1 share/man/man1/afferent-run.1 share/man/man1/afferent-link-status.1
        share/bash-completion/completions/afferent share/zsh/site-functions/_afferent
        share/fish/vendor_completions.d/afferent.fish share/doc/afferent/LICENSE share/doc/afferent/CHANGELOG.md
        share/doc/afferent/README.md share/doc/afferent/docs/install.md share/doc/afferent/examples/grasp.txtpb
        share/doc/afferent/examples/data/grip.csv share/doc/afferent/examples/embed.c share/doc/afferent/proto/scene.proto)
  set(found ${whole})
  list(FILTER found INCLUDE REGEX "^${expected}$")
  if(NOT found)
    message(FATAL_ERROR "${expected} is not installed")
  endif()
endforeach()

# Nothing that is read later names the place where it was built.
file(GLOB_RECURSE texts ${folder}/whole/*.pc ${folder}/whole/*.cmake ${folder}/whole/*.1)
foreach(text IN LISTS texts)
  file(READ ${text} content)
  string(FIND "${content}" "${build}" place)
  if(NOT place EQUAL -1)
    message(FATAL_ERROR "${text} names ${build}")
  endif()
endforeach()
