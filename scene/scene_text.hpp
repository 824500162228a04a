// A scene as text: parsed, with the place of every field kept for messages.
#pragma once

#include <google/protobuf/text_format.h>

#include <functional>
#include <stdexcept>
#include <string>
#include <string_view>
#include <vector>

#include "afferent/proto/scene.pb.h"

namespace afferent {

// What is wrong with a scene, one message a line, each with file, line, column, field and rule:
//
//     scene.txtpb:14:7: patch "thumb": neuron.tau_m_ms must be > 0, is -10
class SceneError : public std::runtime_error {
  public:
    explicit SceneError(std::vector<std::string> messages);
    const std::vector<std::string>& messages() const noexcept { return messages_; }

  private:
    std::vector<std::string> messages_;
};

// Scenes are written by hand; what has more bytes is not one.
inline constexpr std::size_t largest_scene_text = std::size_t{1} << 20;

class SceneText {
  public:
    // Parses Protobuf's text format. Throws SceneError on unknown fields, wrong types and bad syntax. `name`
    // is what messages call the file.
    SceneText(std::string_view text, std::string name);

    const proto::Scene& scene() const noexcept { return scene_; }

    // Where a field stands, as "file:line:column", or else the nearest field around it. Paths are as in
    // "patch[1].neuron.tau_m_ms"; what a patch does not say itself is looked for in every_patch.
    std::string where(std::string_view path) const;

    // Runs a check. A ParameterError becomes a message about the path's field and is kept; `about` (a patch's
    // name, say) goes before it.
    void check(const std::string& path, const std::string& about, const std::function<void()>& rule);
    // Keeps a message about a field.
    void refuse(const std::string& path, const std::string& text);
    // Throws SceneError if anything was kept.
    void throw_if_refused() const;

  private:
    std::string name_;
    proto::Scene scene_;
    google::protobuf::TextFormat::ParseInfoTree places_;
    std::vector<std::string> messages_;
};

}  // namespace afferent
