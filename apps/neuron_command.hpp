// afferent neuron: one neuron for each drive column of a table, for comparing with one's own script.
#pragma once

namespace CLI {
class App;
}

namespace afferent {

void add_neuron_command(CLI::App& app);

}  // namespace afferent
