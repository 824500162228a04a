#include "afferent/scene/scene_schema.hpp"

#include <google/protobuf/descriptor.h>

#include <algorithm>

#include "afferent/proto/scene.pb.h"

namespace afferent {
namespace {

using google::protobuf::Descriptor;
using google::protobuf::FieldDescriptor;

SchemaField::Type type_of(const FieldDescriptor& field) {
    switch (field.cpp_type()) {
        case FieldDescriptor::CPPTYPE_MESSAGE:
            return SchemaField::Type::message;
        case FieldDescriptor::CPPTYPE_ENUM:
            return SchemaField::Type::name;
        case FieldDescriptor::CPPTYPE_STRING:
            return SchemaField::Type::text;
        case FieldDescriptor::CPPTYPE_BOOL:
            return SchemaField::Type::boolean;
        case FieldDescriptor::CPPTYPE_DOUBLE:
            return SchemaField::Type::number;
        default:
            return SchemaField::Type::whole_number;
    }
}

}  // namespace

std::vector<SchemaMessage> scene_schema() {
    std::vector<SchemaMessage> messages;
    std::vector<const Descriptor*> found{proto::Scene::descriptor()};
    // Grows while it is walked over: each message is described once.
    for (std::size_t i = 0; i < found.size(); ++i) {
        const Descriptor& type = *found[i];
        SchemaMessage& message = messages.emplace_back(SchemaMessage{type.name(), {}});
        for (int k = 0; k < type.field_count(); ++k) {
            const FieldDescriptor& field = *type.field(k);
            SchemaField& told = message.fields.emplace_back(SchemaField{field.name(),
                                                                        type_of(field),
                                                                        field.is_repeated(),
                                                                        field.containing_oneof() != nullptr,
                                                                        {},
                                                                        {}});
            if (field.message_type()) {
                told.of = field.message_type()->name();
                if (std::find(found.begin(), found.end(), field.message_type()) == found.end())
                    found.push_back(field.message_type());
            }
            for (int v = 0; field.enum_type() && v < field.enum_type()->value_count(); ++v)
                told.names.push_back(field.enum_type()->value(v)->name());
        }
    }
    return messages;
}

}  // namespace afferent
