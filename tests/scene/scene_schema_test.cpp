#include "afferent/scene/scene_schema.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <set>

#include "afferent/scene/scene.hpp"
#include "tests/value_or_throw.hpp"

namespace afferent {
namespace {

const SchemaField& schema_field(const std::string& message, const std::string& name) {
    static const std::vector<SchemaMessage> schema = scene_schema();
    return found_or_throw(found_or_throw(schema, message, &SchemaMessage::name).fields, name,
                          &SchemaField::name);
}

TEST(SceneSchema, BeginsWithTheSceneAndDescribesEachMessageOnce) {
    const std::vector<SchemaMessage> schema = scene_schema();
    EXPECT_EQ(schema.at(0).name, "Scene");
    std::set<std::string> names;
    for (const SchemaMessage& message : schema)
        EXPECT_TRUE(names.insert(message.name).second) << message.name;
    for (const SchemaMessage& message : schema)
        for (const SchemaField& field : message.fields)
            EXPECT_EQ(names.contains(field.of), field.type == SchemaField::Type::message) << field.name;
}

TEST(SceneSchema, TellsTheTypeOfAField) {
    using Type = SchemaField::Type;
    EXPECT_EQ(schema_field("Scene", "duration_s").type, Type::number);
    EXPECT_EQ(schema_field("Scene", "seed").type, Type::whole_number);
    EXPECT_EQ(schema_field("Scene", "name").type, Type::text);
    EXPECT_EQ(schema_field("Record", "events").type, Type::boolean);
    EXPECT_EQ(schema_field("Decoder", "pooling").names, (std::vector<std::string>{"POOLED", "PER_NEURON"}));
    EXPECT_EQ(schema_field("Scene", "patch").of, "Patch");
    EXPECT_TRUE(schema_field("Scene", "patch").repeated);
    EXPECT_TRUE(schema_field("Decoder", "filter").alternative);
    EXPECT_FALSE(schema_field("Decoder", "contact").alternative);
}

}  // namespace
}  // namespace afferent
