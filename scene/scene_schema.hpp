// The fields that the text of a scene may have, for programs that write or describe scenes.
#pragma once

#include <string>
#include <vector>

namespace afferent {

struct SchemaField {
    enum class Type { number, whole_number, boolean, text, name, message };

    std::string name;
    Type type;
    bool repeated;
    bool alternative;                // one of several, of which a message has one
    std::string of;                  // the message's name
    std::vector<std::string> names;  // what a name may be
};

struct SchemaMessage {
    std::string name;
    std::vector<SchemaField> fields;
};

// The messages of proto/scene.proto; the first is the scene.
std::vector<SchemaMessage> scene_schema();

}  // namespace afferent
