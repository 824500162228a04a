#include "afferent/nodes/command_file.hpp"

namespace afferent {

Result<CommandFile> CommandFile::open(const Scene& scene, const Described& given, FullPipe full_pipe) {
    CommandFile opened(scene.resolve(given.path), full_pipe);
    if (const auto& error = opened.table_.error()) return Error{Error::Kind::unreachable, error->message()};
    return opened;
}

CommandFile::CommandFile(const std::filesystem::path& file, FullPipe full_pipe)
    : table_(file, {"time_s", "force_n", "sigma_n", "gain", "command", "doubt"}, full_pipe) {}

void CommandFile::take(const ControllerStep& step) {
    table_.cell(step.time);
    table_.cell(step.estimate.force_n);
    table_.cell(step.estimate.sigma_n);
    table_.cell(step.gain);
    table_.cell(step.command);
    table_.text(name(step.estimate.doubt));
    table_.end_row();
}

std::optional<std::string> CommandFile::notice() const {
    if (!table_.is_unread()) return std::nullopt;
    return table_.file().string() + ": nobody reads this pipe; until somebody does its rows are lost";
}

Result<void> CommandFile::close() {
    if (const auto error = table_.close()) return Error{Error::Kind::unreachable, error->message()};
    return success();
}

}  // namespace afferent
