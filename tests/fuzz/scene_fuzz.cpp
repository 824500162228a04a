// A scene of any text is read, or refused in words.
#include <string_view>

#include "afferent/scene/plan.hpp"
#include "fuzz.hpp"

int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    using namespace afferent;
    try {
        const Scene scene = Scene::from_text({reinterpret_cast<const char*>(data), size});
        must(make_plan(scene).addresses > 0);
    } catch (const SceneError& error) {
        must(!error.messages().empty());
    }
    return 0;
}
