# Runs an embedding program with a scene: it ends well, and a time and an address are on every line that it prints.
execute_process(COMMAND ${program} ${scene} OUTPUT_VARIABLE events COMMAND_ERROR_IS_FATAL ANY)
if(NOT events MATCHES "^([0-9]+\\.[0-9]+ [0-9]+\n)+$")
  message(FATAL_ERROR "no events:\n${events}")
endif()
