use std::io::{BufRead, BufReader, Write};
use std::net::{SocketAddr, TcpStream};

use serde_json::{Value, json};

use crate::ANSWER_TIME_MAX;

/// A client of the control port: one JSON object per line, answered in order.
pub struct Control {
    requests: TcpStream,
    answers: BufReader<TcpStream>,
    id: u64,
}

impl Control {
    /// A client of the control port at `address`.
    ///
    /// # Panics
    /// If nobody listens there.
    #[must_use]
    pub fn connect(address: SocketAddr) -> Self {
        let requests = TcpStream::connect(address).expect("the control port listens");
        requests.set_read_timeout(Some(ANSWER_TIME_MAX)).expect("a time above zero");
        requests.set_nodelay(true).expect("an open socket");
        let answers = BufReader::new(requests.try_clone().expect("an open socket"));
        Self { requests, answers, id: 0 }
    }

    /// Who is at the other end.
    ///
    /// # Panics
    /// If the connection is gone.
    #[must_use]
    pub fn address(&self) -> SocketAddr {
        self.requests.peer_addr().expect("an open socket")
    }

    /// Sends `verb` with `fields` and waits for the answer.
    ///
    /// # Errors
    /// The sentence of the bench if it refuses.
    ///
    /// # Panics
    /// If `fields` is no object, or the bench does not answer this request.
    pub fn ask(&mut self, verb: &str, fields: Value) -> Result<Value, String> {
        self.id += 1;
        let Value::Object(mut request) = fields else { panic!("{verb}: fields are an object") };
        // The identifier of a frame to send is the name of its request as well.
        let id = request.entry("id").or_insert(json!(self.id)).clone();
        request.insert("do".to_owned(), json!(verb));
        let answer = self.line(&Value::Object(request).to_string());
        assert_eq!(answer.get("id"), Some(&id), "{verb}: {answer}");
        match answer.get("ok") {
            Some(Value::Bool(true)) => Ok(answer),
            Some(Value::Bool(false)) => {
                Err(answer.get("error").and_then(Value::as_str).unwrap_or_default().to_owned())
            }
            _ => panic!("{verb}: no answer but {answer}"),
        }
    }

    /// Sends a line as it is, for tests of what is not a request.
    ///
    /// # Panics
    /// If the bench does not answer with a JSON object.
    pub fn line(&mut self, line: &str) -> Value {
        self.requests.write_all(format!("{line}\n").as_bytes()).expect("the bench is up");
        let mut answer = String::new();
        self.answers.read_line(&mut answer).expect("the bench answers");
        serde_json::from_str(&answer).unwrap_or_else(|_| panic!("{line}: answered {answer:?}"))
    }
}
