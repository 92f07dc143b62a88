//! Columns of a Parquet file: numbers, flags, texts, and lists of equal length.

use std::fs::File;
use std::io::BufWriter;
use std::path::Path;
use std::sync::Arc;

use anyhow::Context;
use parquet::basic::{Compression, LogicalType, Repetition, Type as Physical};
use parquet::data_type::{
    BoolType, ByteArray, ByteArrayType, DataType, DoubleType, FloatType, Int64Type,
};
use parquet::file::metadata::KeyValue;
use parquet::file::properties::WriterProperties;
use parquet::file::writer::{SerializedColumnWriter, SerializedFileWriter};
use parquet::schema::types::Type;

/// Values of a column. A list column stores the values of all rows one after another.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum Values {
    Whole(Vec<i64>),
    Short(Vec<f32>),
    Flag(Vec<bool>),
    Text(Vec<String>),
    /// Length of each list, and the values.
    Shorts(usize, Vec<f32>),
    Numbers(usize, Vec<f64>),
    Texts(usize, Vec<String>),
}

/// Named column.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Column {
    pub(super) name: String,
    pub(super) values: Values,
}

impl Column {
    pub(super) fn new(name: impl Into<String>, values: Values) -> Self {
        Self {
            name: name.into(),
            values,
        }
    }

    /// Size of the values in memory, bytes.
    pub(super) fn bytes(&self) -> usize {
        match &self.values {
            Values::Whole(values) => values.len() * 8,
            Values::Short(values) | Values::Shorts(_, values) => values.len() * 4,
            Values::Numbers(_, values) => values.len() * 8,
            Values::Flag(values) => values.len(),
            Values::Text(values) | Values::Texts(_, values) => values.iter().map(String::len).sum(),
        }
    }

    fn field(&self) -> anyhow::Result<Type> {
        let (physical, logical, is_list) = match self.values {
            Values::Whole(_) => (Physical::INT64, None, false),
            Values::Short(_) => (Physical::FLOAT, None, false),
            Values::Flag(_) => (Physical::BOOLEAN, None, false),
            Values::Text(_) => (Physical::BYTE_ARRAY, Some(LogicalType::String), false),
            Values::Shorts(..) => (Physical::FLOAT, None, true),
            Values::Numbers(..) => (Physical::DOUBLE, None, true),
            Values::Texts(..) => (Physical::BYTE_ARRAY, Some(LogicalType::String), true),
        };
        let name = if is_list { "element" } else { &self.name };
        let value = Type::primitive_type_builder(name, physical)
            .with_repetition(Repetition::REQUIRED)
            .with_logical_type(logical)
            .build()?;
        if !is_list {
            return Ok(value);
        }
        let list = Type::group_type_builder("list")
            .with_repetition(Repetition::REPEATED)
            .with_fields(vec![Arc::new(value)])
            .build()?;
        let field = Type::group_type_builder(&self.name)
            .with_repetition(Repetition::REQUIRED)
            .with_logical_type(Some(LogicalType::List))
            .with_fields(vec![Arc::new(list)]);
        Ok(field.build()?)
    }

    fn write(&self, column: &mut SerializedColumnWriter<'_>) -> parquet::errors::Result<()> {
        fn put<D: DataType>(
            column: &mut SerializedColumnWriter<'_>,
            values: &[D::T],
            length: Option<usize>,
        ) -> parquet::errors::Result<()> {
            let column = column.typed::<D>();
            let Some(length) = length else {
                column.write_batch(values, None, None)?;
                return Ok(());
            };
            let defined = vec![1; values.len()];
            let continues: Vec<i16> = (0..values.len())
                .map(|index| i16::from(!index.is_multiple_of(length)))
                .collect();
            column.write_batch(values, Some(&defined), Some(&continues))?;
            Ok(())
        }
        let texts = |values: &[String]| -> Vec<ByteArray> {
            values.iter().map(|text| text.as_str().into()).collect()
        };
        match &self.values {
            Values::Whole(values) => put::<Int64Type>(column, values, None),
            Values::Short(values) => put::<FloatType>(column, values, None),
            Values::Flag(values) => put::<BoolType>(column, values, None),
            Values::Text(values) => put::<ByteArrayType>(column, &texts(values), None),
            Values::Shorts(length, values) => put::<FloatType>(column, values, Some(*length)),
            Values::Numbers(length, values) => put::<DoubleType>(column, values, Some(*length)),
            Values::Texts(length, values) => {
                put::<ByteArrayType>(column, &texts(values), Some(*length))
            }
        }
    }
}

/// Parquet file; each call of [`Table::write`] appends a row group with the same columns.
pub(super) struct Table {
    file: SerializedFileWriter<BufWriter<File>>,
}

impl Table {
    /// Creates a file with the columns of `like`, and its folder.
    pub(super) fn create(
        path: &Path,
        like: &[Column],
        metadata: Vec<KeyValue>,
    ) -> anyhow::Result<Self> {
        if let Some(folder) = path.parent() {
            std::fs::create_dir_all(folder)
                .with_context(|| format!("could not make the folder {}", folder.display()))?;
        }
        let file = File::create_new(path)
            .with_context(|| format!("could not make the file {}", path.display()))?;
        let fields: anyhow::Result<Vec<_>> =
            like.iter().map(|one| one.field().map(Arc::new)).collect();
        let schema = Type::group_type_builder("schema").with_fields(fields?);
        let properties = WriterProperties::builder()
            .set_compression(Compression::ZSTD(Default::default()))
            .set_key_value_metadata((!metadata.is_empty()).then_some(metadata))
            .build();
        let file = SerializedFileWriter::new(
            BufWriter::new(file),
            Arc::new(schema.build()?),
            Arc::new(properties),
        )?;
        Ok(Self { file })
    }

    pub(super) fn write(&mut self, columns: &[Column]) -> anyhow::Result<()> {
        let mut group = self.file.next_row_group()?;
        for values in columns {
            if let Some(mut column) = group.next_column()? {
                values.write(&mut column)?;
                column.close()?;
            }
        }
        group.close()?;
        Ok(())
    }

    pub(super) fn finish(self) -> anyhow::Result<()> {
        self.file.close()?;
        Ok(())
    }
}
