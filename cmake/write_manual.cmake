# Has a program that was just built write its man pages and completions into a folder.
file(REMOVE_RECURSE ${folder})
execute_process(COMMAND ${emulator} ${program} manual ${folder} OUTPUT_QUIET COMMAND_ERROR_IS_FATAL ANY)
