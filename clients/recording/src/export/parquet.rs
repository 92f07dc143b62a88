//! Apache Parquet: the columns of the table, typed and compressed. Null means not recorded.

use std::fs::File;
use std::io::BufWriter;
use std::sync::Arc;

use parquet::basic::{Compression, LogicalType, Repetition, Type as Physical};
use parquet::data_type::{ByteArray, ByteArrayType, DataType, DoubleType, FloatType, Int64Type};
use parquet::file::metadata::KeyValue;
use parquet::file::properties::WriterProperties;
use parquet::file::writer::{SerializedColumnWriter, SerializedFileWriter};
use parquet::schema::types::Type;

use super::Sink;
use super::subject::Subject;
use super::table::{Cell, Column, Form, columns};
use crate::rows::Row;

/// Ticks per row group. Design choice: 16 s at 1 kHz, about 20 MiB in memory.
const GROUP: usize = 1 << 14;

/// Parquet file.
pub(super) struct Parquet {
    file: SerializedFileWriter<BufWriter<File>>,
    columns: Vec<(Column, Values)>,
    waiting: usize,
}

/// Buffered values of a column, and for each row whether it has one.
enum Values {
    Whole(Waiting<i64>),
    Number(Waiting<f64>),
    Short(Waiting<f32>),
    Text(Waiting<ByteArray>),
}

struct Waiting<T> {
    values: Vec<T>,
    is_there: Vec<i16>,
}

impl<T> Default for Waiting<T> {
    fn default() -> Self {
        Self {
            values: Vec::new(),
            is_there: Vec::new(),
        }
    }
}

impl<T> Waiting<T> {
    fn push(&mut self, value: Option<T>) {
        self.is_there.push(value.is_some().into());
        self.values.extend(value);
    }

    fn write<D: DataType<T = T>>(
        &mut self,
        column: &mut SerializedColumnWriter<'_>,
    ) -> parquet::errors::Result<()> {
        column
            .typed::<D>()
            .write_batch(&self.values, Some(&self.is_there), None)?;
        self.values.clear();
        self.is_there.clear();
        Ok(())
    }
}

impl Values {
    fn of(form: Form) -> Self {
        match form {
            Form::Whole => Self::Whole(Waiting::default()),
            Form::Number => Self::Number(Waiting::default()),
            Form::Short => Self::Short(Waiting::default()),
            Form::Text => Self::Text(Waiting::default()),
        }
    }

    fn push(&mut self, cell: &Cell) {
        match self {
            Self::Whole(waiting) => waiting.push(match cell {
                Cell::Whole(value) => Some(*value),
                _ => None,
            }),
            Self::Number(waiting) => waiting.push(match cell {
                Cell::Number(value) => Some(*value),
                _ => None,
            }),
            Self::Short(waiting) => waiting.push(match cell {
                Cell::Short(value) => Some(*value),
                _ => None,
            }),
            Self::Text(waiting) => waiting.push(match cell {
                Cell::Text(text) => Some(ByteArray::from(text.as_ref())),
                _ => None,
            }),
        }
    }

    fn write(&mut self, column: &mut SerializedColumnWriter<'_>) -> parquet::errors::Result<()> {
        match self {
            Self::Whole(waiting) => waiting.write::<Int64Type>(column),
            Self::Number(waiting) => waiting.write::<DoubleType>(column),
            Self::Short(waiting) => waiting.write::<FloatType>(column),
            Self::Text(waiting) => waiting.write::<ByteArrayType>(column),
        }
    }
}

impl Parquet {
    pub(super) fn new(
        file: BufWriter<File>,
        subject: &Subject,
        elements: bool,
    ) -> anyhow::Result<Self> {
        let columns = columns(subject, elements).into_iter();
        let columns: Vec<_> = columns
            .map(|column| {
                let values = Values::of(column.form);
                (column, values)
            })
            .collect();
        let noted = subject.made_by.iter();
        let noted = noted.map(|(key, text)| KeyValue::new((*key).to_owned(), text.clone()));
        let properties = WriterProperties::builder()
            .set_compression(Compression::ZSTD(Default::default()))
            .set_key_value_metadata(Some(noted.collect()))
            .build();
        let file = SerializedFileWriter::new(file, schema(&columns)?, Arc::new(properties))?;
        Ok(Self {
            file,
            columns,
            waiting: 0,
        })
    }

    fn write_group(&mut self) -> anyhow::Result<()> {
        let mut group = self.file.next_row_group()?;
        for (_, values) in &mut self.columns {
            if let Some(mut column) = group.next_column()? {
                values.write(&mut column)?;
                column.close()?;
            }
        }
        group.close()?;
        self.waiting = 0;
        Ok(())
    }
}

fn schema(columns: &[(Column, Values)]) -> anyhow::Result<Arc<Type>> {
    let fields = columns.iter().map(|(column, _)| {
        let (physical, logical) = match column.form {
            Form::Whole => (Physical::INT64, None),
            Form::Number => (Physical::DOUBLE, None),
            Form::Short => (Physical::FLOAT, None),
            Form::Text => (Physical::BYTE_ARRAY, Some(LogicalType::String)),
        };
        let field = Type::primitive_type_builder(&column.name, physical)
            .with_repetition(Repetition::OPTIONAL)
            .with_logical_type(logical);
        field.build().map(Arc::new)
    });
    let fields = fields.collect::<Result<Vec<_>, _>>()?;
    let ticks = Type::group_type_builder("ticks").with_fields(fields);
    Ok(Arc::new(ticks.build()?))
}

impl Sink for Parquet {
    fn row(&mut self, row: &Row) -> anyhow::Result<()> {
        for (column, values) in &mut self.columns {
            values.push(&column.cell(row));
        }
        self.waiting += 1;
        if self.waiting == GROUP {
            self.write_group()?;
        }
        Ok(())
    }

    fn finish(mut self: Box<Self>) -> anyhow::Result<()> {
        if self.waiting > 0 {
            self.write_group()?;
        }
        self.file.close()?;
        Ok(())
    }
}
